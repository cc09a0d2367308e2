//! A point of an axis: named parents and assignments.

use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::quantity::parse::{Parsed, quantity};
use crate::spec::family::extends;
use crate::spec::marks::below;
use crate::spec::sets::settable;
use crate::syntax::{Entry, Item, Layer, Map, Node};

/// A point of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its name: the key of its table, or its value as written.
    pub name: String,
    /// Place of the name.
    pub place: Span,
    /// Specs that its arms extend, as written, relative to the suite.
    pub extends: Vec<(String, Span)>,
    /// What it assigns.
    pub assigns: Map,
}

impl Point {
    /// A named point: a table of assignments, `extends` among them.
    pub fn named(name: &str, entry: &Entry, sink: &mut Sink) -> Option<Self> {
        let mut node = entry.node.clone();
        node.stamp(Layer::Point);
        let Item::Table(mut assigns) = node.item else {
            let error = wrong_type(name, "a table of assignments", &entry.node);
            sink.emit(match entry.node.text() {
                Some(text) if text.ends_with(".toml") => {
                    let written = format!("{{ extends = {} }}", entry.node.toml());
                    error.help(format!("write `{name} = {written}`")).fix(entry.node.span, written)
                }
                _ => error.help(format!(
                    "write `{name} = {{ KEY = VALUE }}`, or `path` and `values` for an axis of one key"
                )),
            });
            return None;
        };
        if name.is_empty() || name.chars().any(|c| matches!(c, ',' | '=' | '/') || c.is_control()) {
            let error = Diagnostic::error("E0107", format!("invalid point name `{name}`"));
            sink.emit(error.at(entry.key, "").help("avoid `,`, `=` and `/`"));
            return None;
        }
        let (parents, wrong) = extends(assigns.entries.remove("extends").map(|entry| entry.node));
        wrong.iter().for_each(|node| sink.emit(wrong_type("extends", "a path or a list of paths", node)));
        let sound = settable(&assigns, sink) & of_an_arm(&assigns, sink);
        let point = Self { name: name.to_owned(), place: entry.key, extends: parents, assigns };
        (wrong.is_empty() && sound).then_some(point)
    }

    /// A point of an axis with `path` and `values`: this value at that path, given the place of each key.
    pub fn value(path: &[(String, Span)], value: &Node, sink: &mut Sink) -> Option<Self> {
        let name = written(value);
        let mut node = value.clone();
        for (key, place) in path.iter().rev() {
            let map = Map { entries: [(key.clone(), Entry { key: *place, node })].into(), ..Map::default() };
            node = Node { span: *place, layer: Layer::Point, item: Item::Table(map) };
        }
        node.stamp(Layer::Point);
        let Item::Table(assigns) = node.item else { return None };
        if name.is_empty() || name.chars().any(char::is_control) {
            let error = Diagnostic::error("E0107", "this value cannot be the name of a point");
            sink.emit(
                error.at(value.span, "").help("give the points names: `[sweep.AXIS]` with a table for each"),
            );
            return None;
        }
        let sound = settable(&assigns, sink) & of_an_arm(&assigns, sink);
        sound.then_some(Self { name, place: value.span, extends: Vec::new(), assigns })
    }

    /// The paths of the values that it assigns, and the places of their keys.
    pub fn paths(&self) -> Vec<(String, Span)> {
        paths(&self.assigns)
    }

    /// The values that it assigns, by path, in one spelling: `10 %` and `10.0 %` are the same.
    pub fn meanings(&self) -> Vec<(String, String)> {
        leaves(&self.assigns).into_iter().map(|(path, entry)| (path, meaning(&entry.node))).collect()
    }
}

/// A value in one spelling: quantities in SI units and numbers to 12 digits, more than anybody writes and
/// fewer than conversions of units leave uncertain.
fn meaning(node: &Node) -> String {
    match &node.item {
        Item::Text(text) => match quantity(text) {
            Ok(Parsed { si, dimension }) => format!("{:.11e} {dimension:?}", si + 0.0),
            Err(_) => node.toml(),
        },
        Item::Number(number) if number.value.is_finite() => format!("{:.11e}", number.value + 0.0),
        Item::List(items) => {
            let items: Vec<String> = items.iter().map(meaning).collect();
            format!("[{}]", items.join(", "))
        }
        Item::Table(map) => {
            let entries = map.entries.iter().map(|(key, entry)| format!("{key} = {}", meaning(&entry.node)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        Item::Number(_) | Item::Flag(_) | Item::Datetime => node.toml(),
    }
}

/// The paths of the values of a tree of assignments, and the places of their keys.
pub fn paths(assigns: &Map) -> Vec<(String, Span)> {
    leaves(assigns).into_iter().map(|(path, entry)| (path, entry.key)).collect()
}

/// The values of a tree of assignments by path; an empty table counts as one.
fn leaves(assigns: &Map) -> Vec<(String, &Entry)> {
    fn collect<'a>(map: &'a Map, path: &str, found: &mut Vec<(String, &'a Entry)>) {
        for (key, entry) in &map.entries {
            let path = below(path, key);
            match entry.node.table() {
                Some(map) if !map.entries.is_empty() => collect(map, &path, found),
                _ => found.push((path, entry)),
            }
        }
    }
    let mut found = Vec::new();
    collect(assigns, "", &mut found);
    found
}

/// A value as a name: strings without quotes, everything else as written.
pub fn written(node: &Node) -> String {
    node.text().map_or_else(|| node.toml(), str::to_owned)
}

/// Whether assignments concern an arm: the report belongs to the suite.
fn of_an_arm(assigns: &Map, sink: &mut Sink) -> bool {
    let Some(entry) = assigns.entries.get("report") else { return true };
    let error = Diagnostic::error("E0603", "`report` cannot be set by a point")
        .at(entry.key, "a suite has one report");
    sink.emit(error.help("write `[report]` in the suite"));
    false
}
