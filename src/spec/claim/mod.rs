//! Claims: what a suite is expected to show, decoded from one `[[claim]]` table.
//!
//! Covers the keys of a claim and the grammar of `expect` and of arm patterns. Metrics and tests are in the
//! registries; whether the arms exist is checked in `check`.

mod blank;
pub mod cases;
mod expect;
pub mod keys;
mod pattern;
mod read;
#[cfg(test)]
pub mod tests;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use cases::{Alternative, Case, Points, alternatives, cases, unpaired};
pub use expect::{Expectation, Operand, Relation};
pub use keys::Summary;
pub use pattern::{ArmPattern, Term, is_meant};

use super::decode::{self, Decoded};
use super::marks::{self, Marks};
use super::typed::Keys;
use super::{Quantity, Section, Table};
use crate::diag::{Sink, SourceId, Span};
use crate::syntax::{Layer, Node};

/// A claim. Serialized as its decoded table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Table", try_from = "Table")]
pub struct Claim {
    /// Its name.
    pub id: String,
    /// What is claimed, as a sentence.
    pub text: String,
    /// What is measured.
    pub metric: MetricPath,
    /// The arms by their name in `expect`: `a` alone, or `a` and `b`.
    pub sides: BTreeMap<String, ArmPattern>,
    /// How a claim combines the arms that one pattern matches; if absent, each pattern matches one arm.
    pub over: Option<Over>,
    /// What is expected of the sides.
    pub expect: Expectation,
    /// Name of the test.
    pub test: String,
    /// How the runs of an arm are summarized.
    pub summary: Summary,
    /// Two-sided level.
    pub alpha: f64,
    /// The margin of superiority or non-inferiority, in the metric's unit.
    pub margin: Option<Quantity>,
    /// What each run's value is compared with, by difference or ratio.
    pub baseline: Option<Baseline>,
    /// Assumed standard deviation between runs before there are any, in the metric's unit.
    pub spread: Option<Quantity>,
    /// The value, or the difference of two arms, for which the power is computed, in the metric's unit.
    pub effect: Option<Quantity>,
    /// The return at which a metric of learning counts as reached.
    pub threshold: Option<f64>,
    /// Number of training samples that a metric of learning covers; all if absent.
    pub until: Option<f64>,
    /// The parameter of a failure metric.
    pub parameter: Option<String>,
    /// What the paper reports.
    pub paper: Option<Paper>,
    /// The decoded table; [`Claim::of_table`] rebuilds the claim from it.
    pub fields: Table,
    /// The places of all parts, by key; the terms of a pattern as `compare.a.0`, `arm.1`, with the axis as
    /// key and the point as value; the parts of the expectation as `expect.left`, `expect.right`,
    /// `expect.within`; those of the metric as `metric.stage` and `metric.name`.
    pub marks: Marks,
}

/// What the metric of a run is compared with: another stage, another arm's run with the same seed, or both.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline {
    /// The stage: `evaluate.flat`.
    pub stage: String,
    /// The points in which the other arm differs; absent if the run is compared with itself.
    pub twin: Option<ArmPattern>,
    /// Whether the value is the ratio of the two instead of their difference.
    pub relative: bool,
}

/// A metric of a stage.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MetricPath {
    /// The stage: `evaluate.nominal`, `deploy.mujoco`, `learn`.
    pub stage: String,
    /// The metric: `survival`.
    pub name: String,
}

impl MetricPath {
    /// The key of the stage's place in the marks of a claim.
    pub const STAGE: &str = "metric.stage";
    /// The key of the name's place.
    pub const NAME: &str = "metric.name";

    /// The path as text: `evaluate.nominal.survival`.
    pub fn written(&self) -> String {
        format!("{}.{}", self.stage, self.name)
    }
}

/// How a claim combines several arms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Over {
    /// It holds for each.
    Each,
    /// It holds for the mean over them; runs are resampled within each arm.
    Mean,
    /// It holds for each at some point of this axis.
    Some(String),
    /// It holds for each at no point of this axis.
    None(String),
    /// It holds in at least this many comparisons.
    AtLeast(usize),
    /// It holds in at most this many comparisons.
    AtMost(usize),
    /// It holds for the slope of the means over the points of this axis, per point.
    Trend(String),
}

impl Over {
    /// The axis whose points are alternatives.
    pub fn axis(&self) -> Option<&str> {
        match self {
            Self::Some(axis) | Self::None(axis) => Some(axis),
            Self::Each | Self::Mean | Self::AtLeast(_) | Self::AtMost(_) | Self::Trend(_) => None,
        }
    }

    /// The key and the axis it names.
    pub fn named(&self) -> Option<(String, &str)> {
        match self {
            Self::Some(axis) => Some((keys::Quantifier::some.path(), axis)),
            Self::None(axis) => Some((keys::Quantifier::none.path(), axis)),
            Self::Trend(axis) => Some((keys::Quantifier::trend.path(), axis)),
            Self::Each | Self::Mean | Self::AtLeast(_) | Self::AtMost(_) => None,
        }
    }

    /// Whether all comparisons form one sample, each being a stratum.
    pub fn is_joint(&self) -> bool {
        matches!(self, Self::Mean | Self::Trend(_))
    }

    /// `each`, `some axis`, `at least 3`.
    pub fn in_words(&self) -> String {
        match self {
            Self::Each => "each".to_owned(),
            Self::Mean => "mean".to_owned(),
            Self::Some(axis) => format!("some {axis}"),
            Self::None(axis) => format!("no {axis}"),
            Self::AtLeast(count) => format!("at least {count}"),
            Self::AtMost(count) => format!("at most {count}"),
            Self::Trend(axis) => format!("trend of {axis}"),
        }
    }

    /// Parses the output of [`Over::in_words`].
    pub fn of_words(words: &str) -> Option<Self> {
        let axis = |start: &str| words.strip_prefix(start).map(str::to_owned);
        let count = |start: &str| words.strip_prefix(start)?.parse().ok();
        Some(match words {
            "each" => Self::Each,
            "mean" => Self::Mean,
            _ => {
                return (axis("some ").map(Self::Some))
                    .or_else(|| axis("no ").map(Self::None))
                    .or_else(|| axis("trend of ").map(Self::Trend))
                    .or_else(|| count("at least ").map(Self::AtLeast))
                    .or_else(|| count("at most ").map(Self::AtMost));
            }
        })
    }

    /// The minimum or maximum number of comparisons that hold.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::AtLeast(count) | Self::AtMost(count) => Some(*count),
            _ => None,
        }
    }
}

/// What the reproduced paper reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Paper {
    /// Where in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// The reported result.
    pub value: String,
    /// The same as a number in the metric's unit, comparable with the claim's estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<Quantity>,
    /// Whether the claim expects less than that.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weaker: bool,
}

impl Paper {
    /// `Exp. 1: it walks (this claim expects less)`.
    pub fn in_words(&self) -> String {
        let less = if self.weaker { " (this claim expects less)" } else { "" };
        format!("{}: {}{less}", self.place, self.value.trim_end_matches('.'))
    }
}

/// Decodes one `[[claim]]` table. `None` if anything is wrong with it; all mistakes are then in the sink.
///
/// Whether the metric, the test and the arms exist is not checked here.
pub fn decode(node: &Node, sink: &mut Sink) -> Option<Claim> {
    let Decoded { table, marks } = decode::element(node, keys::Claim::PARAMS, sink)?;
    let written = Section::new(&table).read();
    read::claim(written, table, marks, read::Errors::new(sink, node.span))
}

impl Claim {
    /// Rebuilds a claim from the valid decoded table stored in a plan; without places.
    pub fn of_table(table: &Table) -> Option<Self> {
        let nowhere = Span { source: SourceId(0), start: 0, end: 0 };
        let written = keys::Claim::of_table(table)?;
        let mut sink = Sink::default();
        read::claim(written, table.clone(), Marks::default(), read::Errors::new(&mut sink, nowhere))
    }
}

impl Claim {
    /// The place of a key's value; if it is a default or absent, that of the claim's name.
    pub fn place(&self, path: &str) -> Option<Span> {
        let written = self.marks.nearest(path).filter(|mark| mark.layer != Layer::Default);
        written.or_else(|| self.marks.get(keys::Claim::id.name)).map(|mark| mark.value)
    }

    /// The key that says what runs are compared with: `baseline`, or else `twin`.
    pub fn key_of_baseline(&self) -> &'static str {
        let baseline = keys::Claim::baseline.name;
        if self.fields.contains_key(baseline) { baseline } else { keys::Claim::twin.name }
    }

    /// The key of the arms: `arm` or `compare`.
    pub fn key_of_sides(&self) -> &'static str {
        if self.sides.len() == 1 { keys::Claim::arm.name } else { keys::Claim::compare.name }
    }

    /// The key of the arm `a` or `b`: `arm` or `compare.b`.
    pub fn key_of_side(&self, side: &str) -> String {
        let key = self.key_of_sides();
        if self.sides.len() == 1 { key.to_owned() } else { marks::below(key, side) }
    }
}

impl From<Claim> for Table {
    fn from(claim: Claim) -> Self {
        claim.fields
    }
}

impl TryFrom<Table> for Claim {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        Self::of_table(&table).ok_or_else(|| "this table is not a claim".to_owned())
    }
}
