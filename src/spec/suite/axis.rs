//! An axis of a sweep: named points, or one path with its values.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry::{Occupied, Vacant};

use super::limit::MOST;
use super::point::Point;
use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::suggest::nearest;
use crate::syntax::{Entry, Item, Map, Node};

/// Keys of `[sweep]` that are not axes.
pub const RESERVED: &[&str] = &["seeds", "zip", "include", "exclude"];

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Place of its name.
    pub place: Span,
    /// The path that it assigns, for an axis of `path` and `values`.
    pub path: Option<String>,
    /// Its points in the order of the file.
    pub points: Vec<Point>,
}

impl Axis {
    /// Decodes `[sweep.NAME]`. `None` if anything is wrong with it.
    pub fn decode(name: &str, entry: &Entry, sink: &mut Sink) -> Option<Self> {
        let Some(map) = entry.node.table() else {
            let advice =
                format!("write `[sweep.{name}]` with a table for each point, or with `path` and `values`");
            let error = wrong_type(&format!("sweep.{name}"), "a table", &entry.node);
            sink.emit(match nearest(name, RESERVED.iter().copied()) {
                Some(key) => error.help(format!("did you mean `{key}`?")).fix(entry.key, key),
                None => error.help(advice),
            });
            return None;
        };
        let plain = name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-')) && !name.is_empty();
        if !plain {
            let error = Diagnostic::error("E0107", format!("invalid axis name `{name}`"));
            sink.emit(error.at(entry.key, "").help("use letters, digits, `_` and `-`"));
            return None;
        }
        let is_plain = |key: &str| map.get(key).is_some_and(|node| node.table().is_none());
        let by_value = is_plain("path") || is_plain("values");
        let count = match map.get("values").map(|node| &node.item) {
            Some(Item::List(items)) if by_value => items.len(),
            _ => map.entries.len(),
        };
        if count > MOST {
            let error = Diagnostic::error("E0204", format!("the axis `{name}` has {count} points"));
            sink.emit(error.at(entry.key, format!("at most {MOST}")).help("split the suite"));
            return None;
        }
        let (path, points) =
            if by_value { values(name, map, entry, sink)? } else { (None, named(map, sink)?) };
        if points.is_empty() {
            let error =
                Diagnostic::error("E0703", format!("the axis `{name}` has no points")).at(entry.key, "empty");
            sink.emit(error.help("give it a point, or remove it"));
            return None;
        }
        if let Some((first, again)) = alike(&points) {
            let message =
                format!("the points `{}` and `{}` of `{name}` are the same", first.name, again.name);
            let error = Diagnostic::error("E0104", message).at(again.place, "again here");
            sink.emit(error.note(first.place, "first written here").help("keep one of the two"));
            return None;
        }
        Some(Self { name: name.to_owned(), place: entry.key, path, points })
    }

    /// The point of this name.
    pub fn point(&self, name: &str) -> Option<&Point> {
        self.points.iter().find(|point| point.name == name)
    }

    /// All paths that its points assign, each with its first place.
    pub fn paths(&self) -> BTreeMap<String, Span> {
        let mut paths = BTreeMap::new();
        for (path, place) in self.points.iter().flat_map(Point::paths) {
            paths.entry(path).or_insert(place);
        }
        paths
    }
}

/// Points of tables, in the order of the file.
fn named(map: &Map, sink: &mut Sink) -> Option<Vec<Point>> {
    let mut entries: Vec<(&String, &Entry)> = map.entries.iter().collect();
    entries.sort_by_key(|(_, entry)| entry.key.start);
    let points: Vec<_> = entries.into_iter().map(|(name, entry)| Point::named(name, entry, sink)).collect();
    points.into_iter().collect()
}

/// The path and the points of an axis of `path` and `values`.
fn values(name: &str, map: &Map, entry: &Entry, sink: &mut Sink) -> Option<(Option<String>, Vec<Point>)> {
    let mut sound = true;
    for key in ["path", "values"].into_iter().filter(|key| map.get(key).is_none()) {
        let error =
            Diagnostic::error("E0101", format!("missing key `{key}` in `sweep.{name}`")).at(entry.key, "");
        sink.emit(
            error.help("such an axis is `path = \"action.stiffness\"` and `values = [\"100 %\", \"50 %\"]`"),
        );
        sound = false;
    }
    for (key, entry) in map.entries.iter().filter(|(key, _)| !matches!(key.as_str(), "path" | "values")) {
        let error =
            Diagnostic::error("E0102", format!("unknown key `{key}` in `sweep.{name}`")).at(entry.key, "");
        sink.emit(error.help("an axis has either `path` and `values`, or a table for each point"));
        sound = false;
    }
    let path = map.get("path").and_then(|node| path(node, sink));
    let items = match map.get("values").map(|node| (&node.item, node)) {
        Some((Item::List(items), _)) => Some(items),
        Some((_, node)) => {
            sink.emit(wrong_type(&format!("sweep.{name}.values"), "a list", node));
            None
        }
        None => None,
    };
    let (Some(path), Some(items), true) = (path, items, sound) else { return None };
    let points: Vec<_> = items.iter().map(|item| Point::value(&path, item, sink)).collect();
    let points: Vec<Point> = points.into_iter().collect::<Option<_>>()?;
    if let Some((first, again)) = repeated(&points) {
        let error = Diagnostic::error("E0104", format!("`{}` is written twice", again.name))
            .at(again.place, "again here");
        sink.emit(error.note(first.place, "first written here").help("keep one of the two"));
        return None;
    }
    let keys: Vec<String> = path.into_iter().map(|(key, _)| key).collect();
    Some((Some(keys.join(".")), points))
}

/// Two points with the same name.
fn repeated(points: &[Point]) -> Option<(&Point, &Point)> {
    pair(points, |point| &point.name)
}

/// Two points with the same parents and assignments, however these are written, so that their arms would be
/// identical.
fn alike(points: &[Point]) -> Option<(&Point, &Point)> {
    let parents = |point: &Point| point.extends.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    pair(points, |point| (point.meanings(), parents(point)))
}

/// The first point with the same key as an earlier one, preceded by that one.
fn pair<'a, K: Ord>(points: &'a [Point], key: impl Fn(&'a Point) -> K) -> Option<(&'a Point, &'a Point)> {
    let mut known: BTreeMap<K, &Point> = BTreeMap::new();
    points.iter().find_map(|point| match known.entry(key(point)) {
        Occupied(first) => Some((*first.get(), point)),
        Vacant(place) => {
            place.insert(point);
            None
        }
    })
}

/// The keys of a dotted path with their places inside the text.
fn path(node: &Node, sink: &mut Sink) -> Option<Vec<(String, Span)>> {
    let Some(text) = node.text() else {
        sink.emit(wrong_type("path", "a text", node));
        return None;
    };
    let plain = |key: &str| {
        !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
    };
    if !text.split('.').all(plain) {
        let error = Diagnostic::error("E0604", format!("invalid path `{text}`")).at(node.span, "");
        sink.emit(error.help("join keys by dots: `action.stiffness`"));
        return None;
    }
    // The opening quote comes before the first key.
    let mut at = node.span.start + 1;
    let keys = text.split('.').map(|key| {
        let place = Span { start: at, end: at + key.len(), ..node.span };
        at += key.len() + 1;
        (key.to_owned(), place)
    });
    Some(keys.collect())
}
