//! Where a resolved value comes from, for `show --origins` and `why`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use super::profiles::Profiles;
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
    /// A line of the chosen profile, or of one that it extends.
    Profile {
        /// The profile.
        name: String,
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// A point of a suite's sweep.
    Point {
        /// The axis and the point: `control=torque`.
        point: String,
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// An assignment on the command line.
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
            Self::Point { point, file, line } => write!(f, "point {point}, {}:{line}", file.display()),
            Self::Set { assignment } => write!(f, "--set {assignment}"),
        }
    }
}

/// The names of the layers above the files.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    /// The chosen profile.
    pub profile: Option<&'a str>,
    /// All profiles: the chosen one may extend the one that has a value.
    pub overlays: &'a Profiles,
    /// The points of a sweep (`control=torque`) by the path that they assign.
    pub points: &'a BTreeMap<String, String>,
}

impl Layers<'_> {
    /// The point that assigned a path, or a table around it.
    fn point(&self, path: &str) -> String {
        let mut path = path;
        loop {
            if let Some(point) = self.points.get(path) {
                return point.clone();
            }
            let Some((outer, _)) = path.rsplit_once('.') else { return String::new() };
            path = outer;
        }
    }
}

/// The origins of all values except tables.
pub fn origins(
    table: &Table,
    marks: &Marks,
    sources: &Sources,
    layers: &Layers<'_>,
) -> BTreeMap<String, Origin> {
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
            Layer::Profile => {
                let name = layers.overlays.holder(mark.value).or(layers.profile).unwrap_or_default();
                Origin::Profile { name: name.to_owned(), file, line }
            }
            Layer::Point => Origin::Point { point: layers.point(path), file, line },
            Layer::Set => Origin::Set { assignment: source.text.to_string() },
        };
        origins.insert(path.to_owned(), origin);
    });
    origins
}

/// The positions of the line ends of a text.
fn line_breaks(text: &str) -> Vec<usize> {
    text.match_indices('\n').map(|(at, _)| at).collect()
}

/// Calls a function with the path of every value except tables.
fn collect(table: &Table, path: &str, visit: &mut impl FnMut(&str)) {
    for (key, value) in table {
        let path = super::marks::below(path, key);
        match value {
            Value::Table(table) => collect(table, &path, visit),
            _ => visit(&path),
        }
    }
}
