//! Loading: file and parents, profile, assignments, decoding, and the files that the spec names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::body::sections;
use super::decode::{Decoder, derived};
use super::family::{Desk, Family, Header, Library, beside};
use super::marks::below;
use super::origin::{Layers, origins};
use super::project::{self, Shelf};
use super::section::WORDINGS;
use super::suggest::{listed, nearest};
use super::{Attachment, Experiment, LoadOptions, Loaded, Marks, Table, Value, Vocabulary};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::syntax::assign::assignment;
use crate::syntax::{Disk, Entry, Files, Forms, Item, Layer, Map, Node, merge};

/// Loads a spec from the disk. Every mistake that can be found without knowing robots is in the sink.
pub fn load(path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    load_in(&Disk, path, options, vocabulary)
}

/// Loads a spec from any files.
pub fn load_in(files: &dyn Files, path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    let mut loading = Loading::new(files, options, vocabulary);
    let family = Family::gather(path, &mut loading.desk());
    let experiment = family.as_ref().map(|family| loading.experiment(path, family));
    let Loading { sources, mut sink, .. } = loading;
    sort(&mut sink);
    Loaded { sources, sink, experiment, family: family.unwrap_or_default() }
}

/// What the loading of a spec, or of all arms of a suite, works with.
pub(super) struct Loading<'a> {
    pub files: &'a dyn Files,
    pub vocabulary: &'a Vocabulary,
    pub options: &'a LoadOptions,
    pub forms: Forms,
    pub sources: Sources,
    pub sink: Sink,
    pub library: Library,
    attachments: BTreeMap<(&'static str, String), Attachment>,
}

/// A spec and its parents, merged, the chosen profile over them; nothing is decoded yet.
pub(super) struct Merged {
    pub family: Family,
    pub header: Header,
    /// Without the profile.
    pub plain: Map,
    /// With it.
    pub root: Map,
    pub profiles: BTreeMap<String, Entry>,
}

impl Merged {
    /// Whether missing keys are no mistakes.
    pub fn lenient(&self) -> bool {
        self.family.incomplete || self.header.is_abstract
    }
}

/// What is laid over a merged spec, and what the result is called.
pub(super) struct Overlay<'a> {
    /// The file, as named on the command line.
    pub path: &'a Path,
    /// The name of the spec, or of the arm.
    pub name: String,
    /// The points of a sweep, each as a tree, in order.
    pub points: &'a [&'a Map],
    /// The assignments of the command line.
    pub sets: &'a [Map],
    /// The points' names by the path that they assign.
    pub named: &'a BTreeMap<String, String>,
}

impl<'a> Loading<'a> {
    /// Nothing loaded yet.
    pub fn new(files: &'a dyn Files, options: &'a LoadOptions, vocabulary: &'a Vocabulary) -> Self {
        Self {
            files,
            vocabulary,
            options,
            forms: vocabulary.forms(),
            sources: Sources::default(),
            sink: Sink::default(),
            library: Library::default(),
            attachments: BTreeMap::new(),
        }
    }

    /// For reading files.
    pub fn desk(&mut self) -> Desk<'_> {
        Desk { files: self.files, library: &mut self.library, sources: &mut self.sources, sink: &mut self.sink }
    }

    /// A single spec.
    fn experiment(&mut self, path: &Path, family: &Family) -> Experiment {
        let merged = self.merged(family.clone());
        let sets = self.sets();
        let name = merged.header.name.clone().unwrap_or_else(|| stem(path));
        let overlay = Overlay { path, name, points: &[], sets: &sets, named: &BTreeMap::new() };
        let experiment = self.settle(&merged, &overlay);
        self.check_other_profiles(&merged, &experiment);
        experiment
    }

    /// A family, merged, with the chosen profile over it.
    pub fn merged(&mut self, family: Family) -> Merged {
        let mut plain = family.merged(&self.forms);
        let profiles = take_profiles(&mut plain, &mut self.sink);
        let mut merged = Merged { header: family.header(), family, root: plain.clone(), plain, profiles };
        self.overlay_profile(&mut merged);
        merged
    }

    /// Reports what is wrong only with a profile, when none is chosen: it would surprise later.
    fn check_other_profiles(&mut self, merged: &Merged, experiment: &Experiment) {
        let told: BTreeSet<String> = experiment.poisoned.iter().cloned().collect();
        let others = merged.profiles.iter().filter(|_| self.options.profile.is_none());
        for map in others.filter_map(|(_, entry)| entry.node.table()) {
            let mut root = merged.plain.clone();
            merge(&mut root, map, &self.forms);
            let mut found = Sink::default();
            let mut decoder = Decoder::new(&mut found);
            decoder.partial = merged.lenient();
            decoder.told = told.clone();
            decoder.wordings = WORDINGS;
            sections(&root, self.vocabulary, &merged.header, &mut decoder);
            for diagnostic in found.diagnostics {
                if !self.sink.diagnostics.contains(&diagnostic) {
                    self.sink.emit(diagnostic);
                }
            }
        }
    }

    fn overlay_profile(&mut self, merged: &mut Merged) {
        overlay_profile(&mut merged.root, &merged.profiles, self.options, &self.forms, &mut self.sink);
    }

    /// The assignments of the command line, as trees.
    pub fn sets(&mut self) -> Vec<Map> {
        let (sources, sink) = (&mut self.sources, &mut self.sink);
        let parsed = self.options.sets.iter().filter_map(|argument| assignment(argument, sources, sink));
        parsed.collect::<Vec<_>>().into_iter().filter(|map| settable(map, &mut self.sink)).collect()
    }

    /// Decodes a merged spec with what is laid over it.
    pub fn settle(&mut self, merged: &Merged, overlay: &Overlay<'_>) -> Experiment {
        let mut root = merged.root.clone();
        overlay.points.iter().for_each(|point| merge(&mut root, point, &self.forms));
        let with_points = root.clone();
        overlay.sets.iter().for_each(|map| merge(&mut root, map, &self.forms));
        let header = &merged.header;
        let mut decoder = Decoder::new(&mut self.sink);
        decoder.partial = merged.lenient();
        decoder.wordings = WORDINGS;
        let mut table = sections(&root, self.vocabulary, header, &mut decoder);
        let (marks, poisoned) = (decoder.marks, decoder.poisoned);
        let place = header.place.unwrap_or(Span { source: SourceId(0), start: 0, end: 0 });
        table.insert("name".to_owned(), Value::Text(overlay.name.clone()));
        table.insert("summary".to_owned(), Value::Text(header.summary.clone()));
        let replaced = replaced(&marks, &[&merged.plain, &merged.root, &with_points], &self.sources);
        let layers = Layers { profile: self.options.profile.as_deref(), points: overlay.named };
        let origins = origins(&table, &marks, &self.sources, &layers);
        let mut experiment = Experiment {
            path: overlay.path.to_owned(),
            source: place.source,
            name: overlay.name.clone(),
            summary: header.summary.clone(),
            is_abstract: header.is_abstract,
            origins,
            replaced,
            poisoned: poisoned.into_iter().collect(),
            compare: Vec::new(),
            profile: self.options.profile.clone(),
            profiles: merged.profiles.keys().cloned().collect(),
            allow: allowed(&table),
            root: project::root(self.files, overlay.path),
            robot: None,
            motion: None,
            table,
            marks,
        };
        experiment.table.remove("allow");
        experiment.compare = compared(&experiment, &self.sources);
        experiment.robot = self.attach(&experiment, ("robot", "model"), &robots(self.vocabulary));
        experiment.motion = self.attach(&experiment, ("task", "motion"), &motions(self.vocabulary));
        experiment
    }

    /// The file that a key names; each is read once.
    fn attach(
        &mut self,
        experiment: &Experiment,
        (section, key): (&str, &str),
        shelf: &Shelf<'_>,
    ) -> Option<Attachment> {
        let name = experiment.section(section)?.text_if(key)?;
        let place = experiment.marks.get(&below(section, key))?.value;
        let known = (shelf.folder, name.to_owned());
        if let Some(attachment) = self.attachments.get(&known) {
            return Some(attachment.clone());
        }
        let folder = (self.files, experiment.root.as_deref());
        let found = shelf.find(name, place, folder, (&mut self.sources, &mut self.sink))?;
        self.attachments.insert(known, found.clone());
        Some(found)
    }
}

/// The shelf of robot files.
pub fn robots(vocabulary: &Vocabulary) -> Shelf<'_> {
    Shelf { noun: "robot", folder: "robots", code: "E0401", embedded: &vocabulary.robots }
}

/// The shelf of motion files.
pub fn motions(vocabulary: &Vocabulary) -> Shelf<'_> {
    Shelf { noun: "motion", folder: "specs/motions", code: "E0304", embedded: &vocabulary.motions }
}

/// The profiles of a merged spec, taken out of it.
fn take_profiles(root: &mut Map, sink: &mut Sink) -> BTreeMap<String, Entry> {
    let Some(entry) = root.entries.remove("profile") else { return BTreeMap::new() };
    let wrong = |node: &Node, what: &str| {
        Diagnostic::error("E0103", format!("{what} is a table, found {}", node.describe())).at(node.span, "not a table")
    };
    let Item::Table(map) = entry.node.item else {
        sink.emit(wrong(&entry.node, "`profile`"));
        return BTreeMap::new();
    };
    let mut profiles = map.entries;
    profiles.retain(|name, entry| {
        let sound = entry.node.table().is_some();
        if !sound {
            sink.emit(wrong(&entry.node, &format!("`profile.{name}`")));
        }
        entry.node.stamp(Layer::Profile);
        sound
    });
    profiles
}

/// Lays the chosen profile over a spec.
fn overlay_profile(
    root: &mut Map,
    profiles: &BTreeMap<String, Entry>,
    options: &LoadOptions,
    forms: &Forms,
    sink: &mut Sink,
) {
    let Some(name) = &options.profile else { return };
    match profiles.get(name).and_then(|entry| entry.node.table()) {
        Some(map) => merge(root, map, forms),
        None => {
            let names = || profiles.keys().map(String::as_str);
            let error = Diagnostic::error("E0706", format!("unknown profile `{name}`"));
            sink.emit(match nearest(name, names()) {
                Some(near) => error.help(format!("did you mean `--profile {near}`?")),
                None => error.help(format!("the profiles of this spec are {}", listed(names()))),
            });
        }
    }
}

/// Whether assignments may be made: what is derived cannot be set.
pub(super) fn settable(map: &Map, sink: &mut Sink) -> bool {
    fn look(map: &Map, path: &str, sink: &mut Sink) -> bool {
        let mut sound = true;
        for (key, entry) in &map.entries {
            let path = below(path, key);
            if let Some(error) = derived(&path, entry) {
                sink.emit(error);
                sound = false;
            } else if let Some(map) = entry.node.table() {
                sound &= look(map, &path, sink);
            }
        }
        sound
    }
    look(map, "", sink)
}

/// What the values of a profile or of an assignment replaced, in trees from weak to strong.
fn replaced(marks: &Marks, below: &[&Map], sources: &Sources) -> BTreeMap<String, Vec<(Span, Layer)>> {
    // A table with a header is no single value; an inline table is.
    let single = |node: &Node| {
        node.table().is_none()
            || sources.get(node.span.source).text.get(node.span.start..).is_some_and(|text| text.starts_with('{'))
    };
    let over = marks.by_path.iter().filter(|(_, mark)| mark.layer > Layer::File);
    let found = over.filter_map(|(path, mark)| {
        let mut places: Vec<(Span, Layer)> = Vec::new();
        for node in below.iter().filter_map(|root| root.at(path)).filter(|node| node.layer < mark.layer && single(node))
        {
            if !places.contains(&(node.span, node.layer)) {
                places.push((node.span, node.layer));
            }
        }
        (!places.is_empty()).then(|| (path.clone(), places))
    });
    found.collect()
}

fn allowed(table: &Table) -> BTreeMap<String, String> {
    let Some(Value::Table(allow)) = table.get("allow") else { return BTreeMap::new() };
    let texts = allow.iter().filter_map(|(code, reason)| match reason {
        Value::Text(reason) => Some((code.clone(), reason.clone())),
        _ => None,
    });
    texts.collect()
}

/// The specs of `report.compare`, relative to the file that names them.
fn compared(experiment: &Experiment, sources: &Sources) -> Vec<PathBuf> {
    let Some(report) = experiment.section("report") else { return Vec::new() };
    let file = experiment.marks.get("report.compare").map(|mark| (mark.layer, &sources.get(mark.value.source).name));
    let file = match file {
        Some((Layer::Set, _)) | None => &experiment.path,
        Some((_, file)) => file,
    };
    report.texts("compare").iter().map(|name| beside(file, name)).collect()
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "spec".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Orders diagnostics by file and place; what has no place comes first.
pub(super) fn sort(sink: &mut Sink) {
    sink.diagnostics.sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
}
