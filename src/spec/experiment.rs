//! A loaded spec: its values, where they come from, and the files that belong to it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::family::Family;
use super::origin::{Layers, origins};
use super::profiles::Profiles;
use super::typed::Part;
use super::{Marks, Origin, Reach, Section, Table, Value};
use crate::diag::{Sink, SourceId, Sources, Span};
use crate::syntax::Layer;

/// Command-line options for loading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// `--profile`
    pub profile: Option<String>,
    /// `--set path=value`, in order.
    pub sets: Vec<String>,
    /// `--deny warnings`
    pub deny_warnings: bool,
    /// `--allow-outside`: folders outside of the project that may be read.
    pub allow_outside: Vec<PathBuf>,
    /// Whether to skip the checks of profiles that are not chosen.
    pub without_profiles: bool,
}

impl LoadOptions {
    /// Whether the options change the spec as written.
    pub fn varies(&self) -> bool {
        self.profile.is_some() || !self.sets.is_empty()
    }
}

/// A spec named by a key of another file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedSpec {
    /// Its file.
    pub path: PathBuf,
    /// Where it is named.
    pub place: Option<Span>,
}

/// The result of loading.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// All texts, for diagnostics.
    pub sources: Sources,
    /// What was found.
    pub sink: Sink,
    /// The spec as far as it could be decoded; complete only if the sink has no errors.
    pub experiment: Option<Experiment>,
    /// The files that make up the spec.
    pub family: Family,
}

/// A resolved spec.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Its file, as named on the command line.
    pub path: PathBuf,
    /// Its text.
    pub source: SourceId,
    /// Its name.
    pub name: String,
    /// A one-sentence summary.
    pub summary: String,
    /// Whether it is an abstract parent, which cannot be run.
    pub is_abstract: bool,
    /// The decoded sections, and `name` and `summary`. Tables with an invalid value are absent.
    pub table: Table,
    /// The places of all values.
    pub marks: Marks,
    /// The points of a sweep (`control=torque`) by the path that they assign.
    pub points: BTreeMap<String, String>,
    /// For values of a profile or an assignment: the values they replaced, by path, lowest priority first.
    pub replaced: BTreeMap<String, Vec<(Span, Layer)>>,
    /// Paths of tables that are absent because they contain an error.
    pub poisoned: Vec<String>,
    /// Specs to run and report together with this one.
    pub compare: Vec<PathBuf>,
    /// Specs whose values the report compares with.
    pub baselines: Vec<NamedSpec>,
    /// The chosen profile.
    pub profile: Option<String>,
    /// The profiles themselves.
    pub overlays: Arc<Profiles>,
    /// All profiles that could be chosen, sorted.
    pub profiles: Arc<[String]>,
    /// Allowed warnings by code, with the reason.
    pub allow: BTreeMap<String, String>,
    /// The folder that contains `robots/`, if the spec is below one.
    pub root: Option<PathBuf>,
    /// Which files it may read.
    pub reach: Reach,
    /// The robot's file.
    pub robot: Option<Attachment>,
    /// The reference motion's file.
    pub motion: Option<Attachment>,
}

/// A file that a spec names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Its name without folder and ending.
    pub name: String,
    /// Its text, for diagnostics.
    pub source: SourceId,
    /// Its location; `None` is the copy embedded in the program.
    pub path: Option<PathBuf>,
    /// Its text.
    pub text: Arc<str>,
}

impl Experiment {
    /// A section, if it is present and valid.
    pub fn section(&self, name: &str) -> Option<Section<'_>> {
        match self.table.get(name) {
            Some(Value::Table(table)) => Some(Section::new(table)),
            _ => None,
        }
    }

    /// A section as its Rust type, if it is present and valid.
    pub fn part<P: Part>(&self) -> Option<P> {
        Section::new(&self.table).part()
    }

    /// The chosen profile and those that it extends, lowest priority first.
    pub fn lineage(&self) -> Vec<&str> {
        self.profile.iter().flat_map(|name| self.overlays.lineage(name)).collect()
    }

    /// The name of the profile that has a value; the chosen one if that is unknown.
    pub fn profile_of(&self, place: Span) -> &str {
        self.overlays.holder(place).or(self.profile.as_deref()).unwrap_or_default()
    }

    /// The origins of all values except tables, by path, given the texts that the spec was loaded from.
    /// Computed on demand, as most commands do not need them.
    pub fn origins(&self, sources: &Sources) -> BTreeMap<String, Origin> {
        let layers =
            Layers { profile: self.profile.as_deref(), overlays: &self.overlays, points: &self.points };
        origins(&self.table, &self.marks, sources, &layers)
    }

    /// The origins as texts.
    pub fn origin_texts(&self, sources: &Sources) -> BTreeMap<String, String> {
        self.origins(sources).into_iter().map(|(path, origin)| (path, origin.to_string())).collect()
    }
}
