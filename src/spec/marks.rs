//! Where every decoded value was written, by path: `reward.torque.weight`, `links.3.mass`.

use std::collections::BTreeMap;

use crate::diag::Span;
use crate::syntax::Layer;

/// The place of a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Place of its key; for a default, of the table.
    pub key: Span,
    /// Place of the value.
    pub value: Span,
    /// The layer that set it.
    pub layer: Layer,
    /// The value as TOML as written; empty for a table that is not a single value.
    pub text: String,
}

/// The places of all values of a decoded table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    /// By path: keys and list indices joined by dots.
    pub by_path: BTreeMap<String, Mark>,
}

impl Marks {
    /// The place of a value.
    pub fn get(&self, path: &str) -> Option<&Mark> {
        self.by_path.get(path)
    }

    /// The places of all values except defaults, which have none.
    pub fn places(&self) -> BTreeMap<String, Span> {
        let written = self.by_path.iter().filter(|(_, mark)| mark.layer != Layer::Default);
        written.map(|(path, mark)| (path.clone(), mark.value)).collect()
    }

    /// The place of a value, or of the innermost table or list around it. Indices may be written `[3]` or
    /// `.3`.
    pub fn nearest(&self, path: &str) -> Option<&Mark> {
        let path = path.replace('[', ".").replace(']', "");
        let mut path = path.as_str();
        loop {
            if let Some(mark) = self.by_path.get(path) {
                return Some(mark);
            }
            path = path.rsplit_once('.')?.0;
        }
    }
}

/// A path extended by one key.
pub fn below(path: &str, key: &str) -> String {
    // `format!` takes six times as long, and decoding calls this for every key of a spec.
    if path.is_empty() { key.to_owned() } else { [path, ".", key].concat() }
}
