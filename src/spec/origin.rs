//! Where a resolved value comes from, for `show --origins` and `why`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use super::{Marks, Table, Value};
use crate::diag::{SourceId, Sources};
use crate::syntax::Layer;

/// The origin of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The default of its kind or section.
    Default,
    /// A line of the spec or of one of its parents.
    File {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// A line of the chosen profile.
    Profile {
        /// The profile.
        name: String,
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// An assignment of the command line.
    Set {
        /// The assignment.
        assignment: String,
    },
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File { file, line } => write!(f, "{}:{line}", file.display()),
            Self::Profile { name, file, line } => write!(f, "profile {name}, {}:{line}", file.display()),
            Self::Set { assignment } => write!(f, "--set {assignment}"),
        }
    }
}

/// The origins of all values that are no tables.
pub fn origins(table: &Table, marks: &Marks, sources: &Sources, profile: Option<&str>) -> BTreeMap<String, Origin> {
    let mut origins = BTreeMap::new();
    let mut breaks: BTreeMap<SourceId, Vec<usize>> = BTreeMap::new();
    collect(table, "", &mut |path| {
        let Some(mark) = marks.get(path) else { return };
        let source = sources.get(mark.value.source);
        let breaks = breaks.entry(mark.value.source).or_insert_with(|| line_breaks(&source.text));
        let line = breaks.partition_point(|at| *at < mark.value.start) + 1;
        let file = source.name.clone();
        let origin = match mark.layer {
            Layer::Default => Origin::Default,
            Layer::File => Origin::File { file, line },
            Layer::Profile => Origin::Profile { name: profile.unwrap_or_default().to_owned(), file, line },
            Layer::Set => Origin::Set { assignment: source.text.to_string() },
        };
        origins.insert(path.to_owned(), origin);
    });
    origins
}

/// Where the lines of a text end.
fn line_breaks(text: &str) -> Vec<usize> {
    text.match_indices('\n').map(|(at, _)| at).collect()
}

/// Calls a function with the path of every value that is no table.
fn collect(table: &Table, path: &str, visit: &mut impl FnMut(&str)) {
    for (key, value) in table {
        let path = super::marks::below(path, key);
        match value {
            Value::Table(table) => collect(table, &path, visit),
            _ => visit(&path),
        }
    }
}
