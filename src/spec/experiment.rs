//! A loaded spec: its values, where they come from, and the files that belong to it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::family::Family;
use super::origin::{Layers, origins};
use super::typed::Part;
use super::{Marks, Origin, Reach, Section, Table, Value};
use crate::diag::{Sink, SourceId, Sources, Span};
use crate::syntax::Layer;

/// What the command line says about loading.
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
    /// Whether mistakes that a profile would bring are of no interest.
    pub without_profiles: bool,
}

impl LoadOptions {
    /// Whether they ask for anything but the spec as it is written.
    pub fn varies(&self) -> bool {
        self.profile.is_some() || !self.sets.is_empty()
    }
}

/// A spec that a key of another file names.
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
    /// The spec, as far as it could be understood; complete only when the sink has no errors.
    pub experiment: Option<Experiment>,
    /// The files that it was put together from.
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
    /// What it is about, in one sentence.
    pub summary: String,
    /// Whether it is a parent that cannot be run.
    pub is_abstract: bool,
    /// The decoded sections, and `name` and `summary`. A table with a value that failed is absent.
    pub table: Table,
    /// The places of all values.
    pub marks: Marks,
    /// The points of a sweep (`control=torque`) by the path that they assign.
    pub points: BTreeMap<String, String>,
    /// For values of a profile or of an assignment: the values that they replaced, by path, the weakest
    /// first.
    pub replaced: BTreeMap<String, Vec<(Span, Layer)>>,
    /// Paths of tables that are absent because something in them failed.
    pub poisoned: Vec<String>,
    /// Specs to be run and reported beside this one.
    pub compare: Vec<PathBuf>,
    /// Specs that the page compares values with.
    pub baselines: Vec<NamedSpec>,
    /// The chosen profile.
    pub profile: Option<String>,
    /// All profiles that could be chosen, sorted.
    pub profiles: Arc<[String]>,
    /// Allowed warnings by code, with the reason.
    pub allow: BTreeMap<String, String>,
    /// The folder that holds `robots/`, if the spec lies below one.
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
    /// Where it lies; `None` is the copy inside the program.
    pub path: Option<PathBuf>,
    /// Its text.
    pub text: Arc<str>,
}

impl Experiment {
    /// A section, when it is there and sound.
    pub fn section(&self, name: &str) -> Option<Section<'_>> {
        match self.table.get(name) {
            Some(Value::Table(table)) => Some(Section::new(table)),
            _ => None,
        }
    }

    /// A section in Rust, when it is there and sound.
    pub fn part<P: Part>(&self) -> Option<P> {
        Section::new(&self.table).part()
    }

    /// The origins of all values that are no tables, by path, with the texts that the spec was loaded from.
    /// They are many, and most commands need none.
    pub fn origins(&self, sources: &Sources) -> BTreeMap<String, Origin> {
        let layers = Layers { profile: self.profile.as_deref(), points: &self.points };
        origins(&self.table, &self.marks, sources, &layers)
    }

    /// The origins as texts.
    pub fn origin_texts(&self, sources: &Sources) -> BTreeMap<String, String> {
        self.origins(sources).into_iter().map(|(path, origin)| (path, origin.to_string())).collect()
    }
}
