//! What parents require: keys that a spec must set because a parent has no value that fits every child.

use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::Vocabulary;
use crate::spec::suggest::{listed, nearest};
use crate::syntax::{Item, Map, Node};

/// A path that a file requires, and where it says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Required {
    /// `fine_tune.std`
    pub path: String,
    /// The text in the list.
    pub place: Span,
}

/// The value of `requires`, and its items that are not texts.
pub fn requires(node: Option<Node>) -> (Vec<Required>, Vec<Node>) {
    let items = match node {
        None => Vec::new(),
        Some(Node { item: Item::List(items), .. }) => items,
        Some(node) => return (Vec::new(), vec![node]),
    };
    let (texts, wrong): (Vec<Node>, Vec<Node>) = items.into_iter().partition(|item| item.text().is_some());
    let required = |item: Node| Some(Required { path: item.text()?.to_owned(), place: item.span });
    (texts.into_iter().filter_map(required).collect(), wrong)
}

/// The spec that is held against what its parents require.
pub struct Child<'a> {
    /// Merged with its parents, profile and assignments.
    pub root: &'a Map,
    /// Where keys missing from the whole file are reported.
    pub place: Option<Span>,
    /// Whether keys may be missing, as in an abstract parent.
    pub lenient: bool,
}

/// Reports required keys that neither the spec nor a parent sets. A section that is absent or switched off
/// requires nothing.
pub fn check<'a>(
    required: impl Iterator<Item = &'a Required>,
    child: &Child<'_>,
    vocabulary: &Vocabulary,
    sink: &mut Sink,
) {
    for required in required {
        let found = match unknown_section(required, vocabulary) {
            Some(error) => Some(error),
            None if child.lenient => None,
            None => missing(required, child),
        };
        if let Some(error) = found.filter(|error| !sink.diagnostics.contains(error)) {
            sink.emit(error);
        }
    }
}

/// E0604 if the path begins with no section.
fn unknown_section(required: &Required, vocabulary: &Vocabulary) -> Option<Diagnostic> {
    let names = || vocabulary.sections.iter().map(|section| section.name);
    let (section, key) = required.path.split_once('.').unwrap_or((&required.path, ""));
    if names().any(|name| name == section) && !key.is_empty() {
        return None;
    }
    let error = Diagnostic::error("E0604", format!("`{}` is not a path of a key", required.path));
    let error = error.at(required.place, "");
    Some(match nearest(section, names()).filter(|near| *near != section && !key.is_empty()) {
        Some(near) => error.help(format!("did you mean `{near}.{key}`?")),
        None => error.help(format!("write SECTION.KEY; the sections are {}", listed(names()))),
    })
}

/// E0101 if the merged spec has no value at the path.
fn missing(required: &Required, child: &Child<'_>) -> Option<Diagnostic> {
    let (section, _) = required.path.split_once('.')?;
    let present = child.root.get(section).filter(|node| !switched_off(node));
    if present.is_none() || child.root.at(&required.path).is_some() {
        return None;
    }
    let error = Diagnostic::error("E0101", format!("missing key `{}`", required.path));
    let error = match child.place {
        Some(place) => error.at(place, "set neither in this spec nor in a parent"),
        None => error,
    };
    let (table, key) = required.path.rsplit_once('.')?;
    let error = error.at(required.place, "this parent requires it of every spec");
    Some(error.help(format!("write `{key}` in `[{table}]`, or in the same table of the chosen profile")))
}

fn switched_off(section: &Node) -> bool {
    let enabled = section.table().and_then(|map| map.get("enabled"));
    enabled.is_some_and(|node| node.item == Item::Flag(false))
}
