//! Suites: one TOML file (`suite = "..."` in place of `name`) that multiplies specs over the axes of a sweep
//! and states what they should show. Works on trees, places and names, independent of the behaviour of kinds
//! and the cost of runs.
//!
//! An arm is a combination of one point per axis; a run is an arm with a learning seed.

pub mod axis;
mod body;
pub mod figures;
mod limit;
pub mod load;
pub mod point;
pub mod product;
pub mod seeds;
pub mod selection;
pub mod sweep;

use std::path::PathBuf;

use super::{Experiment, NamedSpec, Table};
use crate::diag::{Diagnostic, SourceId, Span};
use crate::syntax::Node;

pub use axis::Axis;
pub use figures::Wanted;
pub use load::{LoadedArm, LoadedSuite, load};
pub use point::Point;
pub use selection::Pattern;
pub use sweep::Sweep;

/// The effect of a failed claim on a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClaimPolicy {
    /// It is reported.
    #[default]
    Report,
    /// It is reported, and the run ends with exit code 5.
    Count,
}

/// A suite without its arms.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Its file, as named on the command line.
    pub path: PathBuf,
    /// Its text.
    pub source: SourceId,
    /// Its name, also that of its report.
    pub name: String,
    /// A one-sentence summary.
    pub summary: String,
    /// Place of its name.
    pub place: Span,
    /// The sweep, under the chosen profile.
    pub sweep: Sweep,
    /// The tables `[[claim]]`, in order; decoded when they are checked.
    pub claims: Vec<Node>,
    /// The effect of a failed claim under the chosen profile.
    pub policy: ClaimPolicy,
    /// The decoded section `[report]`.
    pub report: Table,
    /// The specs that the report compares the arms' values with.
    pub baselines: Vec<NamedSpec>,
    /// The figures requested, with their places.
    pub figures: Vec<(Wanted, Span)>,
    /// The chosen profile.
    pub profile: Option<String>,
    /// All profiles that could be chosen: those of the suite and those of its arms' specs, sorted.
    pub profiles: Vec<String>,
}

/// An arm: a spec with the points of one combination applied.
#[derive(Clone, Debug)]
pub struct Arm {
    /// `control=torque,stiffness=100 %`; the suite's name without axes.
    pub name: String,
    /// Axis and point, in the order of the axes.
    pub points: Vec<(String, String)>,
    /// The resolved spec.
    pub experiment: Experiment,
}

/// Whether a text is a suite rather than a spec: whether `suite` is assigned before its first table.
pub fn is_suite(text: &str) -> bool {
    let top = text.lines().map(str::trim_start).take_while(|line| !line.starts_with('['));
    top.filter_map(|line| line.strip_prefix("suite")).any(|rest| rest.trim_start().starts_with('='))
}

/// E0103: something of the wrong type.
fn wrong_type(what: &str, expected: &str, node: &Node) -> Diagnostic {
    let message = format!("`{what}` takes {expected}, found {}", node.describe());
    Diagnostic::error("E0103", message).at(node.span, "wrong type")
}

#[cfg(test)]
mod tests;
