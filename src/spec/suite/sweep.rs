//! `[sweep]`: the axes, zipped axes, selected combinations and the seeds.

use std::collections::BTreeMap;

use super::axis::{Axis, RESERVED};
use super::point::paths;
use super::seeds::{self, Seed};
use super::selection::Pattern;
use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::suggest::{listed, nearest};
use crate::syntax::{Entry, Item, Map, Node};

/// The path that seeds assign.
pub const SEED_PATH: &str = "learn.seed";

/// Maximum number of axes of a sweep.
const MOST_AXES: usize = 32;
/// Maximum number of patterns of `include` and of `exclude`: each is compared with every combination.
const MOST_PATTERNS: usize = 1000;

/// A sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Its place.
    pub place: Span,
    /// The axes in the order of the file.
    pub axes: Vec<Axis>,
    /// Groups of zipped axes, by index.
    pub zips: Vec<Vec<usize>>,
    /// If not empty, only combinations that match one of these are selected.
    pub include: Vec<Pattern>,
    /// Combinations that match one of these are excluded, or only the seeds that it names.
    pub exclude: Vec<Pattern>,
    /// The learning seeds of every arm; if absent, each arm uses its spec's own.
    pub seeds: Option<Vec<Seed>>,
    /// How much of it is valid.
    pub grasp: Grasp,
}

/// How much of a sweep is valid. Its arms are exact only if all of it is; otherwise they serve to find
/// mistakes that do not depend on the missing part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grasp {
    /// All of it.
    Full,
    /// All axes, but not which combinations and seeds are selected.
    Axes,
    /// Some axes are missing, so arms lack the keys that they assign.
    Part,
}

impl Sweep {
    /// The sweep of a suite without a valid `[sweep]`: one arm with the suite's own sections.
    pub fn missing(place: Span) -> Self {
        let (axes, zips, include, exclude) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { place, axes, zips, include, exclude, seeds: None, grasp: Grasp::Part }
    }

    /// The same sweep with all combinations of its axes.
    pub fn unrestricted(&self) -> Self {
        Self {
            include: Vec::new(),
            exclude: Vec::new(),
            grasp: self.grasp.without_selection(),
            ..self.clone()
        }
    }

    /// Decodes the table. `seeds` of a profile or the command line override its own. Invalid parts are left
    /// out; see `grasp`.
    pub fn decode(entry: &Entry, seeds: Option<&Node>, sink: &mut Sink) -> Self {
        let Some(map) = entry.node.table() else {
            sink.emit(wrong_type("sweep", "a table", &entry.node));
            return Self::missing(entry.key);
        };
        let mut entries: Vec<(&String, &Entry)> = map.entries.iter().collect();
        entries.sort_by_key(|(_, entry)| entry.key.start);
        let axes = entries.into_iter().filter(|(name, _)| !RESERVED.contains(&name.as_str()));
        let axes: Vec<(&String, &Entry)> = axes.collect();
        if let Some((_, entry)) = axes.get(MOST_AXES) {
            let error = Diagnostic::error("E0009", format!("the sweep has more than {MOST_AXES} axes"));
            sink.emit(error.at(entry.key, "one too many").help("split the suite"));
            return Self::missing(entry.key);
        }
        let axes: Vec<Option<Axis>> =
            axes.into_iter().map(|(name, entry)| Axis::decode(name, entry, sink)).collect();
        let own = map.get("seeds").map(|node| seeds::decode(node, sink));
        let seeds = seeds.map(|node| seeds::decode(node, sink)).or(own);
        let all_known = axes.iter().all(Option::is_some);
        let axes: Vec<Axis> = axes.into_iter().flatten().collect();
        let mut sweep = Self { axes, seeds: seeds.clone().flatten(), ..Self::missing(entry.key) };
        // Names of axes are checked only if all axes are known.
        if !all_known {
            return sweep;
        }
        let zips = map.get("zip").map_or(Some(Vec::new()), |node| zips(node, &sweep.axes, sink));
        let include = patterns(map, "include", &sweep.axes, sink);
        let exclude = patterns(map, "exclude", &sweep.axes, sink);
        let seeds_known = seeds.is_none_or(|seeds| seeds.is_some());
        let known = [zips.is_some(), include.is_some(), exclude.is_some(), seeds_known];
        sweep.zips = zips.unwrap_or_default();
        sweep.include = include.unwrap_or_default();
        sweep.exclude = exclude.unwrap_or_default();
        let known = sweep.paths_are_set_once(sink) && !known.contains(&false);
        sweep.grasp = if known { Grasp::Full } else { Grasp::Axes };
        sweep
    }

    /// E0704: two axes must not assign the same path, or a path and one below it.
    fn paths_are_set_once(&self, sink: &mut Sink) -> bool {
        let mut sets: Vec<(&str, BTreeMap<String, Span>)> =
            self.axes.iter().map(|axis| (axis.name.as_str(), axis.paths())).collect();
        let seed = self.seeds.iter().flatten().next().map(|(_, place)| (SEED_PATH.to_owned(), *place));
        sets.extend(seed.map(|seed| ("seeds", BTreeMap::from([seed]))));
        let mut sound = true;
        for (at, (second, paths)) in sets.iter().enumerate() {
            for (first, earlier) in &sets[..at] {
                let clash = paths.iter().find_map(|(path, place)| {
                    let (other, there) = overlapping(path, earlier)?;
                    Some((path, place, other, there))
                });
                if let Some((path, place, other, there)) = clash {
                    let shorter = if path.len() < other.len() { path } else { other };
                    let error = Diagnostic::error(
                        "E0704",
                        format!("two axes set `{shorter}`: `{first}` and `{second}`"),
                    );
                    let error = error
                        .at(*place, format!("set by `{second}`"))
                        .note(*there, format!("set by `{first}`"));
                    sink.emit(error.help("let one axis set it, or make one axis whose points set both"));
                    sound = false;
                }
            }
        }
        sound
    }
}

impl Sweep {
    /// The learning seeds of an arm, given its points: the sweep's without those excluded; `None` if each arm
    /// uses its spec's own.
    pub fn seeds_of(&self, arm: &[(String, String)]) -> Option<Vec<u64>> {
        let left_out =
            |seed: u64| self.exclude.iter().any(|out| out.seeds.contains(&seed) && out.matches(arm));
        let all = self.seeds.as_ref()?.iter().map(|(seed, _)| *seed);
        Some(all.filter(|seed| !left_out(*seed)).collect())
    }

    /// E0704: the command line must not assign what an axis sets. Returns the valid assignments.
    pub fn leaves_alone(&self, assigned: Vec<Map>, sink: &mut Sink) -> Vec<Map> {
        let paths_of: Vec<_> = self.axes.iter().map(|axis| (axis, axis.paths())).collect();
        let swept =
            |path: &str| paths_of.iter().find_map(|(axis, own)| overlapping(path, own).map(|_| *axis));
        let mut sound = |map: &Map| {
            let clash = paths(map).into_iter().find_map(|(path, place)| Some((swept(&path)?, path, place)));
            if let Some((axis, path, place)) = &clash {
                let message = format!("`{path}` is set by the sweep: by its axis `{}`", axis.name);
                let error = Diagnostic::error("E0704", message).at(*place, "would make its points equal");
                sink.emit(error.note(axis.place, "the axis").help("change the points in the suite"));
            }
            clash.is_none()
        };
        assigned.into_iter().filter(|map| sound(map)).collect()
    }
}

/// The path among others that equals, contains or is below this one.
fn overlapping<'a>(path: &str, others: &'a BTreeMap<String, Span>) -> Option<(&'a String, &'a Span)> {
    let around = path.match_indices('.').map(|(at, _)| &path[..at]).chain([path]);
    let below = format!("{path}.");
    around.filter_map(|outer| others.get_key_value(outer)).next().or_else(|| {
        let (other, place) = others.range::<String, _>(&below..).next()?;
        other.starts_with(&below).then_some((other, place))
    })
}

impl Grasp {
    /// What remains of it without the selection of combinations.
    fn without_selection(self) -> Self {
        if self == Self::Full { Self::Axes } else { self }
    }
}

/// `[[sweep.include]]` and `[[sweep.exclude]]`.
fn patterns(map: &Map, key: &str, axes: &[Axis], sink: &mut Sink) -> Option<Vec<Pattern>> {
    let Some(node) = map.get(key) else { return Some(Vec::new()) };
    let Item::List(items) = &node.item else {
        sink.emit(
            wrong_type(&format!("sweep.{key}"), "tables of its own", node)
                .help(format!("write `[[sweep.{key}]]`")),
        );
        return None;
    };
    if let Some(item) = items.get(MOST_PATTERNS) {
        let error =
            Diagnostic::error("E0009", format!("`sweep.{key}` has more than {MOST_PATTERNS} patterns"));
        sink.emit(
            error
                .at(item.span, "one too many")
                .help("a pattern may name several points: `a = [\"x\", \"y\"]`"),
        );
        return None;
    }
    let decode = |item: &Node, sink: &mut Sink| match &item.item {
        Item::Table(map) if key == "exclude" => Pattern::decode_with_seeds(map, item.span, axes, sink),
        Item::Table(map) => Pattern::decode(map, item.span, axes, sink),
        _ => {
            sink.emit(wrong_type(&format!("sweep.{key}"), "tables of points by axis", item));
            None
        }
    };
    let patterns: Vec<_> = items.iter().map(|item| decode(item, sink)).collect();
    patterns.into_iter().collect()
}

/// `zip = ["a", "b"]`, or a list of such lists.
fn zips(node: &Node, axes: &[Axis], sink: &mut Sink) -> Option<Vec<Vec<usize>>> {
    let Item::List(items) = &node.item else {
        sink.emit(wrong_type("sweep.zip", "a list of axes", node).help("write `zip = [\"a\", \"b\"]`"));
        return None;
    };
    let nested = !items.is_empty() && items.iter().all(|item| matches!(item.item, Item::List(_)));
    let groups: Vec<&Node> = if nested { items.iter().collect() } else { vec![node] };
    let mut used = Vec::new();
    let decoded: Vec<_> = groups.into_iter().map(|group| zip(group, axes, &mut used, sink)).collect();
    decoded.into_iter().collect()
}

/// One group of zipped axes: each exists, is in only one group, and all have the same length (E0701).
fn zip(node: &Node, axes: &[Axis], used: &mut Vec<usize>, sink: &mut Sink) -> Option<Vec<usize>> {
    let Item::List(items) = &node.item else { return None };
    let mut group = Vec::new();
    for item in items {
        let Some(name) = item.text() else {
            sink.emit(wrong_type("sweep.zip", "names of axes", item));
            return None;
        };
        let Some(index) = axes.iter().position(|axis| axis.name == name) else {
            let names = || axes.iter().map(|axis| axis.name.as_str());
            let error =
                Diagnostic::error("E0702", format!("the sweep has no axis `{name}`")).at(item.span, "");
            sink.emit(match nearest(name, names()) {
                Some(near) => {
                    error.help(format!("did you mean `{near}`?")).fix(item.span, format!("\"{near}\""))
                }
                None => error.help(format!("the axes are {}", listed(names()))),
            });
            return None;
        };
        if used.contains(&index) {
            let error = Diagnostic::error("E0104", format!("the axis `{name}` is zipped twice"))
                .at(item.span, "again");
            sink.emit(error.help("name each axis once"));
            return None;
        }
        used.push(index);
        group.push(index);
    }
    let [first, rest @ ..] = group.as_slice() else {
        sink.emit(
            Diagnostic::error("E0701", "`zip` names no axes")
                .at(node.span, "")
                .help("name two axes, or remove it"),
        );
        return None;
    };
    let count = |index: &usize| axes[*index].points.len();
    if let Some(other) = rest.iter().find(|other| count(other) != count(first)) {
        let (a, b) = (&axes[*first], &axes[*other]);
        let message =
            format!("`{}` has {} points and `{}` has {}", a.name, count(first), b.name, count(other));
        let error =
            Diagnostic::error("E0701", message).at(node.span, "zipped axes are combined point by point");
        let error = error
            .note(a.place, format!("{} points", count(first)))
            .note(b.place, format!("{} points", count(other)));
        sink.emit(error.help("give both the same number of points, or remove one from `zip`"));
        return None;
    }
    Some(group)
}
