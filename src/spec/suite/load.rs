//! Loading a suite: its file, the specs of its points, each read once, and every arm decoded.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::body::{Parts, split};
use super::figures::{self, Wanted};
use super::product::{Cell, arm_name};
use super::sweep::{Grasp, SEED_PATH};
use super::{Arm, Point, Suite, Sweep};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::spec::decode::Decoder;
use crate::spec::family::{Family, Library, beside};
use crate::spec::load::{Loading, Merged, Overlay, is_unknown_profile, sort};
use crate::spec::marks::below;
use crate::spec::section;
use crate::spec::typed::{InSection, Keys};
use crate::spec::{LoadOptions, NamedSpec, Shape, Table, Vocabulary};
use crate::syntax::{Entry, Files, Item, Layer, Map, Node, merge};

/// A suite and its arms, with their diagnostics.
#[derive(Clone, Debug, Default)]
pub struct LoadedSuite {
    /// All texts, for diagnostics.
    pub sources: Sources,
    /// What was found in the suite itself.
    pub sink: Sink,
    /// The suite; absent if its file is invalid. If its sweep has mistakes (see `grasp`), the arms are those
    /// of the valid part.
    pub suite: Option<Suite>,
    /// Its arms in the order of the sweep.
    pub arms: Vec<LoadedArm>,
}

/// An arm with its diagnostics.
#[derive(Clone, Debug)]
pub struct LoadedArm {
    /// The arm.
    pub arm: Arm,
    /// The files that make it up; other arms may share them.
    pub family: Arc<Family>,
    /// The diagnostics of its spec; other arms may share them.
    pub sink: Sink,
}

/// Loads a suite. All mistakes that can be found without robots are in a sink.
pub fn load(files: &dyn Files, path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> LoadedSuite {
    let mut loading = Loading::new(files, path, options, vocabulary);
    let (suite, arms) = match suite(path, &mut loading) {
        Some((suite, arms)) => (Some(suite), arms),
        None => (None, Vec::new()),
    };
    let Loading { sources, mut sink, .. } = loading;
    sort(&mut sink);
    LoadedSuite { sources, sink, suite, arms }
}

fn suite(path: &Path, loading: &mut Loading<'_>) -> Option<(Suite, Vec<LoadedArm>)> {
    let file = Library::own(path, &mut loading.desk())?;
    let place = file.header.suite?;
    let parts = split(&file, loading.options, loading.vocabulary, &mut loading.sink);
    let (of_suite, of_arms) = assignments(loading, &parts);
    let seeds = of_suite.get("sweep").and_then(Node::table).and_then(|sweep| sweep.get("seeds"));
    let Report { table: report, figures, baselines } =
        report(&parts, of_suite.entries.get("report"), path, loading);
    let sweep = match &parts.sweep {
        Some(entry) => Sweep::decode(entry, seeds.or(parts.profile_seeds.as_ref()), &mut loading.sink),
        None => {
            let error =
                Diagnostic::error("E0101", "missing section `sweep`").at(place, "a suite needs a sweep");
            loading.sink.emit(error.help("add `[sweep]` with `seeds = 3` or an axis"));
            Sweep::missing(place)
        }
    };
    let of_arms = sweep.leaves_alone(of_arms, &mut loading.sink);
    // If the sweep has a mistake, an empty product is only a consequence.
    let mut unheard = Sink::default();
    let certain = sweep.grasp == Grasp::Full;
    let cells = sweep.cells(if certain { &mut loading.sink } else { &mut unheard });
    let (sweep, cells) = match cells.is_empty() {
        true => {
            let all = sweep.unrestricted();
            let cells = all.cells(&mut unheard);
            (all, cells)
        }
        false => (sweep, cells),
    };
    let mut bases = Bases { path, parts: &parts, known: BTreeMap::new() };
    let profiles = bases.all(&sweep, &cells, loading);
    once(&profiles, &mut loading.sink);
    let mut arms = Vec::with_capacity(cells.len());
    let name = file.header.name.clone().unwrap_or_else(|| "suite".to_owned());
    for cell in &cells {
        let base = bases.known.get(&bases.parents(&sweep, cell)).and_then(Option::as_ref);
        arms.extend(base.map(|base| arm(&name, &sweep, cell, base, &of_arms, path, loading)));
    }
    let suite = Suite {
        path: path.to_owned(),
        source: file.source,
        name,
        summary: file.header.summary.clone(),
        place,
        sweep,
        claims: parts.claims,
        policy: parts.policy,
        report,
        baselines,
        figures,
        profile: loading.options.profile.clone(),
        profiles,
    };
    Some((suite, arms))
}

/// The assignments of the command line, split into those to the suite and those to its arms.
fn assignments(loading: &mut Loading<'_>, parts: &Parts) -> (Map, Vec<Map>) {
    let (mut of_suite, mut of_arms) = (Map::default(), Vec::new());
    for map in loading.sets() {
        let own = |key: &String| matches!(key.as_str(), "sweep" | "report");
        let swept = parts.sweep.as_ref().and_then(|entry| entry.node.table()?.get("seeds")).is_some();
        let seed = map.get("learn").and_then(|node| node.table()?.entries.get("seed"));
        if let Some(entry) = seed.filter(|_| swept || parts.profile_seeds.is_some()) {
            let error =
                Diagnostic::error("E0705", format!("`{SEED_PATH}` is set by the sweep, once for each seed"));
            let error = error.at(entry.key, "would make all runs of an arm the same");
            loading.sink.emit(error.help("choose the seeds with `--set \"sweep.seeds=[7]\"`"));
            continue;
        }
        if map.entries.keys().any(own) {
            if let Some(sweep) = map.entries.get("sweep") {
                only_seeds(sweep, &mut loading.sink);
            }
            merge(&mut of_suite, &map, &loading.forms);
        } else {
            of_arms.push(map);
        }
    }
    (of_suite, of_arms)
}

/// E0604: of a sweep only the seeds can be set.
fn only_seeds(entry: &Entry, sink: &mut Sink) {
    let keys = entry.node.table().into_iter().flat_map(|map| &map.entries);
    let other =
        keys.into_iter().find(|(key, _)| *key != "seeds").map(|(key, entry)| (key.as_str(), entry.key));
    let wrong = if entry.node.table().is_some() { other } else { Some(("", entry.key)) };
    if let Some((key, place)) = wrong {
        let error = Diagnostic::error("E0604", format!("path `{}` cannot be set", below("sweep", key)));
        sink.emit(error.at(place, "").help("of the sweep, only `sweep.seeds` can be set"));
    }
}

/// The section `[report]` and what it names.
struct Report {
    /// Decoded.
    table: Table,
    figures: Vec<(Wanted, Span)>,
    baselines: Vec<NamedSpec>,
}

/// The section `[report]`, with its assignments.
fn report(parts: &Parts, set: Option<&Entry>, suite: &Path, loading: &mut Loading<'_>) -> Report {
    let place = parts.member.header.suite.unwrap_or(Span { source: parts.member.source, start: 0, end: 0 });
    let mut own = parts.report.clone().unwrap_or_else(|| {
        let node = Node { span: place, layer: Layer::Default, item: Item::Table(Map::default()) };
        Entry { key: place, node }
    });
    if let (Some(map), Some(set)) = (own.node.table_mut(), set.and_then(|entry| entry.node.table())) {
        merge(map, set, &loading.forms);
    }
    let compare = own.node.table_mut().and_then(|map| map.entries.remove("compare"));
    if let Some(entry) = compare {
        let error = Diagnostic::error(
            "E0102",
            "`report.compare` is not supported in a \
             suite",
        )
        .at(entry.key, "");
        loading.sink.emit(error.help("a suite compares its arms: add a point with `extends`"));
    }
    let table = Decoder::new(&mut loading.sink)
        .plain(&own.node, section::Report::PARAMS, section::Report::SECTION)
        .unwrap_or_default();
    let figures = match own.node.table().and_then(|map| map.get("figures")).map(|node| &node.item) {
        Some(Item::List(figures)) => {
            figures.iter().filter_map(|figure| figures::known(figure, &mut loading.sink)).collect()
        }
        _ => Vec::new(),
    };
    let baselines = own.node.table().and_then(|map| map.get("baseline"));
    let baselines = baselines.map(|node| baselines_of(node, suite, &loading.sources)).unwrap_or_default();
    Report { table, figures, baselines }
}

/// The specs of `report.baseline`, relative to the suite.
fn baselines_of(node: &Node, suite: &Path, sources: &Sources) -> Vec<NamedSpec> {
    let items = match &node.item {
        Item::List(items) => items.as_slice(),
        _ => std::slice::from_ref(node),
    };
    let named = |item: &Node| {
        let Item::Text(name) = &item.item else { return None };
        let file = if item.layer == Layer::Set { suite } else { &sources.get(item.span.source).name };
        Some(NamedSpec { path: beside(file, name), place: Some(item.span) })
    };
    items.iter().filter_map(named).collect()
}

/// Several lists of parents have the same mistakes: report each once. If only some arms lack the chosen
/// profile, suggest those of the others.
fn once(profiles: &[String], sink: &mut Sink) {
    let mut kept: Vec<Diagnostic> = Vec::new();
    for mut found in std::mem::take(&mut sink.diagnostics) {
        let unknown_profile = is_unknown_profile(&found);
        let known = kept.iter().any(|kept| *kept == found || (unknown_profile && kept.code == "E0706"));
        if unknown_profile && profiles.iter().any(|name| found.message.ends_with(&format!("`{name}`"))) {
            found.help =
                vec!["some of the arms have it; write it in the suite too, for all of them".to_owned()];
        }
        if !known {
            kept.push(found);
        }
    }
    sink.diagnostics = kept;
}

/// The merged parents of the arms, one entry per list of parents.
struct Bases<'a> {
    path: &'a Path,
    parts: &'a Parts,
    known: BTreeMap<Vec<String>, Option<Merged>>,
}

impl Bases<'_> {
    /// Merges the parents of every cell; returns the names of all profiles.
    fn all(&mut self, sweep: &Sweep, cells: &[Cell], loading: &mut Loading<'_>) -> Vec<String> {
        for cell in cells {
            let key = self.parents(sweep, cell);
            if !self.known.contains_key(&key) {
                let merged = self.merged(sweep, cell, loading);
                self.known.insert(key, merged);
            }
        }
        let merged = self.known.values().flatten();
        let mut profiles: Vec<String> =
            merged.flat_map(|merged| merged.profiles.names().map(str::to_owned)).collect();
        profiles.sort();
        profiles.dedup();
        profiles
    }

    /// The parents of an arm, which identify its base.
    fn parents(&self, sweep: &Sweep, cell: &Cell) -> Vec<String> {
        self.extended(sweep, cell).into_iter().map(|(name, _)| name).collect()
    }

    fn extended(&self, sweep: &Sweep, cell: &Cell) -> Vec<(String, Span)> {
        let of_points = points(sweep, cell).flat_map(|(_, point)| point.extends.clone());
        self.parts.member.header.extends.iter().cloned().chain(of_points).collect()
    }

    fn merged(&self, sweep: &Sweep, cell: &Cell, loading: &mut Loading<'_>) -> Option<Merged> {
        let parents = self.extended(sweep, cell);
        let sections = |key: &String| !matches!(key.as_str(), "profile" | "allow");
        let may_extend = sweep.grasp == Grasp::Part;
        if parents.is_empty() && !may_extend && !self.parts.member.body.entries.keys().any(sections) {
            let arm = arm_name(&sweep.named(&cell.points), "this suite");
            let error = Diagnostic::error("E0101", format!("the arm `{arm}` has no spec"));
            let place = points(sweep, cell).next().map_or(sweep.place, |(_, point)| point.place);
            loading.sink.emit(
                error
                    .at(place, "")
                    .help("add `extends = \"SPEC.toml\"` to the point, or at the top for all arms"),
            );
            return None;
        }
        let mut family = Family::of_parents(self.path, &parents, &mut loading.desk());
        family.incomplete |= self.parts.member.header.lost_parent || sweep.grasp == Grasp::Part;
        // A suite has one report; those of its specs apply only when they run alone.
        for member in &mut family.members {
            if member.body.entries.contains_key("report") {
                Arc::make_mut(member).body.entries.remove("report");
            }
        }
        family.members.push(self.parts.member.clone());
        Some(loading.under_profile(family))
    }
}

/// The points of a cell with the names of their axes, in the order of the axes.
fn points<'a>(sweep: &'a Sweep, cell: &'a Cell) -> impl Iterator<Item = (&'a str, &'a Point)> {
    sweep.axes.iter().zip(&cell.points).map(|(axis, point)| (axis.name.as_str(), &axis.points[*point]))
}

fn arm(
    suite: &str,
    sweep: &Sweep,
    cell: &Cell,
    base: &Merged,
    sets: &[Map],
    path: &Path,
    loading: &mut Loading<'_>,
) -> LoadedArm {
    let idle = idle(sweep, cell, base, loading);
    let taken: Vec<(&str, &Point)> = points(sweep, cell)
        .enumerate()
        .filter(|(axis, _)| !idle.contains(axis))
        .map(|(_, point)| point)
        .collect();
    let mut named = BTreeMap::new();
    for (axis, point) in &taken {
        named.extend(point.paths().into_iter().map(|(path, _)| (path, format!("{axis}={}", point.name))));
    }
    let maps: Vec<&Map> = taken.iter().map(|(_, point)| &point.assigns).collect();
    let pairs = sweep.named(&cell.points);
    let name = arm_name(&pairs, suite);
    let outer = std::mem::take(&mut loading.sink);
    let overlay = Overlay { path, name: name.clone(), points: &maps, sets, named: &named };
    let experiment = loading.settle(base, &overlay);
    let mut sink = std::mem::replace(&mut loading.sink, outer);
    sort(&mut sink);
    LoadedArm { arm: Arm { name, points: pairs, experiment }, family: Arc::new(base.family.clone()), sink }
}

/// The axes of one path without effect in this arm: `exclude` left them one point, and the key belongs to
/// another kind than the arm has. For example, `stiffness` does not exist where `control` is torque.
fn idle(sweep: &Sweep, cell: &Cell, base: &Merged, loading: &Loading<'_>) -> Vec<usize> {
    let candidate = |axis: &usize| {
        cell.alone[*axis] && sweep.axes[*axis].path.is_some() && sweep.axes[*axis].points.len() > 1
    };
    let candidates: Vec<usize> = (0..sweep.axes.len()).filter(candidate).collect();
    if candidates.is_empty() {
        return candidates;
    }
    let mut root = Map::clone(&base.root);
    for (_, (_, point)) in points(sweep, cell).enumerate().filter(|(axis, _)| !candidates.contains(axis)) {
        merge(&mut root, &point.assigns, &loading.forms);
    }
    let foreign = |axis: &usize| {
        let path = sweep.axes[*axis].path.as_deref().unwrap_or_default();
        is_of_another_kind(path, &root, loading.vocabulary)
    };
    candidates.into_iter().filter(foreign).collect()
}

/// Whether a key belongs to another kind of its section than the present one.
fn is_of_another_kind(path: &str, root: &Map, vocabulary: &Vocabulary) -> bool {
    let mut keys = path.split('.');
    let (Some(section), Some(key)) = (keys.next(), keys.next()) else { return false };
    let Some(Shape::Kind(kinds)) = vocabulary.section(section).map(|section| &section.shape) else {
        return false;
    };
    let kind = root.get(section).and_then(Node::table).and_then(|map| map.get("kind")).and_then(Node::text);
    let has = |name: Option<&str>| {
        let mut known = kinds.iter().filter(|known| name.is_none_or(|name| known.name == name));
        known.any(|known| known.params.iter().any(|param| param.name == key))
    };
    kind.is_some_and(|kind| kinds.iter().any(|known| known.name == kind)) && !has(kind) && has(None)
}
