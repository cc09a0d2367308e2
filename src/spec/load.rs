//! Loading: file and parents, profile, assignments, decoding, and the files that the spec names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::body::sections;
use super::decode::Decoder;
use super::family::{Desk, Family, Header, LONGEST_NAME, Library, beside};
use super::folder;
use super::marks::below;
use super::mistake::WORDINGS;
use super::profiles::Profiles;
use super::project::{Project, Shelf};
use super::reach::Reach;
use super::requires;
use super::section::{self, Report, Specs};
use super::sets::{settable, unique};
use super::suggest::{listed, nearest};
use super::{
    Attachment, Experiment, LoadOptions, Loaded, Marks, NamedSpec, Section, Table, Value, Vocabulary,
};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::syntax::assign::assignment;
use crate::syntax::{Disk, Files, Forms, Layer, Map, Node, merge};

/// Loads a spec from disk. All mistakes that can be found without the robot are in the sink.
pub fn load(path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    load_in(&Disk, path, options, vocabulary)
}

/// Loads a spec from any file system.
pub fn load_in(files: &dyn Files, path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    Gathered::read(files, path, &options.allow_outside, vocabulary).load(files, options, vocabulary)
}

/// A spec and its parents, read and merged once, to load under any of its profiles. There may be a thousand
/// profiles, which all share the merged files.
#[derive(Clone, Debug)]
pub struct Gathered {
    path: PathBuf,
    forms: Forms,
    sources: Sources,
    sink: Sink,
    merged: Option<Merged>,
}

impl Gathered {
    /// Reads a spec and its parents, which may be in these folders outside its project.
    pub fn read(files: &dyn Files, path: &Path, outside: &[PathBuf], vocabulary: &Vocabulary) -> Self {
        let options = LoadOptions { allow_outside: outside.to_vec(), ..LoadOptions::default() };
        let mut loading = Loading::new(files, path, &options, vocabulary);
        let family = Family::gather(path, &mut loading.desk());
        let merged = family.map(|family| loading.merged(family));
        let Loading { forms, sources, sink, .. } = loading;
        Self { path: path.to_owned(), forms, sources, sink, merged }
    }

    /// The names of its profiles; none if there is a mistake in the files.
    pub fn profiles(&self) -> Arc<[String]> {
        let merged = self.merged.as_ref().filter(|_| !self.sink.has_errors());
        merged.map(|merged| merged.names.clone()).unwrap_or_default()
    }

    /// Loads it under a profile, with assignments.
    pub fn load(&self, files: &dyn Files, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
        let (sources, sink) = (self.sources.clone(), self.sink.clone());
        let mut loading =
            Loading::with(files, &self.path, options, vocabulary, self.forms.clone(), sources, sink);
        let experiment = self.merged.clone().map(|merged| loading.experiment(&self.path, merged));
        let Loading { sources, mut sink, .. } = loading;
        sort(&mut sink);
        let family = self.merged.as_ref().map(|merged| merged.family.clone()).unwrap_or_default();
        Loaded { sources, sink, experiment, family }
    }
}

/// Whether a diagnostic is about the profile chosen on the command line; an unknown name in a spec has a
/// place.
pub fn is_unknown_profile(found: &Diagnostic) -> bool {
    found.code == "E0706" && found.labels.is_empty()
}

/// Shared state for loading a spec or all arms of a suite.
pub(super) struct Loading<'a> {
    pub files: &'a dyn Files,
    pub reach: Reach,
    pub vocabulary: &'a Vocabulary,
    pub options: &'a LoadOptions,
    pub forms: Forms,
    pub sources: Sources,
    pub sink: Sink,
    pub library: Library,
    attachments: BTreeMap<(&'static str, String), Attachment>,
}

/// A spec and its parents, merged, with the chosen profile on top; not decoded yet.
#[derive(Clone, Debug)]
pub(super) struct Merged {
    pub family: Family,
    pub header: Header,
    /// Without the profile.
    pub plain: Arc<Map>,
    /// With the profile.
    pub root: Arc<Map>,
    pub profiles: Arc<Profiles>,
    /// Their names.
    pub names: Arc<[String]>,
}

impl Merged {
    /// Whether missing keys are allowed.
    pub fn lenient(&self) -> bool {
        self.family.incomplete || self.header.is_abstract
    }
}

/// What is applied on top of a merged spec, and the name of the result.
pub(super) struct Overlay<'a> {
    /// The file, as named on the command line.
    pub path: &'a Path,
    /// The name of the spec, or of the arm.
    pub name: String,
    /// The points of a sweep as trees, in order.
    pub points: &'a [&'a Map],
    /// The assignments of the command line.
    pub sets: &'a [Map],
    /// The points' names by the path that they assign.
    pub named: &'a BTreeMap<String, String>,
}

impl<'a> Loading<'a> {
    /// Nothing loaded yet.
    pub fn new(
        files: &'a dyn Files,
        spec: &Path,
        options: &'a LoadOptions,
        vocabulary: &'a Vocabulary,
    ) -> Self {
        let (sources, sink) = (Sources::default(), Sink::default());
        Self::with(files, spec, options, vocabulary, vocabulary.forms(), sources, sink)
    }

    /// With existing texts and diagnostics.
    fn with(
        files: &'a dyn Files,
        spec: &Path,
        options: &'a LoadOptions,
        vocabulary: &'a Vocabulary,
        forms: Forms,
        sources: Sources,
        sink: Sink,
    ) -> Self {
        Self {
            files,
            reach: Reach::of(files, spec, &options.allow_outside),
            vocabulary,
            options,
            forms,
            sources,
            sink,
            library: Library::default(),
            attachments: BTreeMap::new(),
        }
    }

    /// State for reading files.
    pub fn desk(&mut self) -> Desk<'_> {
        let Self { files, reach, library, sources, sink, .. } = self;
        Desk { files: *files, reach, library, sources, sink }
    }

    /// A single spec.
    fn experiment(&mut self, path: &Path, mut merged: Merged) -> Experiment {
        self.overlay_profile(&mut merged);
        let sets = self.sets();
        let name = merged.header.name.clone().unwrap_or_else(|| stem(path));
        if name.len() > LONGEST_NAME && merged.header.name.is_none() {
            let message = format!("the file name is too long for the report: {} bytes", name.len());
            let error = Diagnostic::error("E0107", message)
                .help(format!("give the spec a `name` of at most {LONGEST_NAME} bytes"));
            self.sink.emit(match merged.header.place {
                Some(place) => error.at(place, "a file without `name`"),
                None => error,
            });
        }
        let overlay = Overlay { path, name, points: &[], sets: &sets, named: &BTreeMap::new() };
        let experiment = self.settle(&merged, &overlay);
        self.check_other_profiles(&merged, &experiment);
        experiment
    }

    /// The merged family without any profile.
    fn merged(&mut self, family: Family) -> Merged {
        let mut plain = family.merged(&self.forms);
        let profiles = Profiles::take(&mut plain, &mut self.sink);
        let names = profiles.names().map(str::to_owned).collect();
        let plain = Arc::new(plain);
        Merged {
            header: family.header(),
            family,
            root: plain.clone(),
            plain,
            profiles: Arc::new(profiles),
            names,
        }
    }

    /// The merged family with the chosen profile on top.
    pub fn under_profile(&mut self, family: Family) -> Merged {
        let mut merged = self.merged(family);
        self.overlay_profile(&mut merged);
        merged
    }

    /// If no profile is chosen, reports mistakes that appear only with one.
    fn check_other_profiles(&mut self, merged: &Merged, experiment: &Experiment) {
        // A file with too many entries is probably the wrong file, and checking each profile would take
        // minutes.
        if self.sink.diagnostics.iter().any(|found| found.code == "E0009") {
            return;
        }
        let mut told: BTreeSet<String> = experiment.poisoned.iter().cloned().collect();
        let others = merged
            .profiles
            .names()
            .filter(|_| self.options.profile.is_none() && !self.options.without_profiles);
        for name in others {
            let mut root = Map::clone(&merged.plain);
            merged.profiles.chain(name).into_iter().for_each(|map| merge(&mut root, map, &self.forms));
            let mut found = Sink::default();
            let mut decoder = Decoder::new(&mut found);
            decoder.partial = merged.lenient();
            decoder.told = std::mem::take(&mut told);
            decoder.wordings = WORDINGS;
            decoder.without_marks = true;
            sections(&root, self.vocabulary, &merged.header, &mut decoder);
            told = decoder.told;
            for diagnostic in found.diagnostics {
                if !self.sink.diagnostics.contains(&diagnostic) {
                    self.sink.emit(diagnostic);
                }
            }
        }
    }

    /// Applies the chosen profile to a spec.
    fn overlay_profile(&mut self, merged: &mut Merged) {
        let Some(name) = &self.options.profile else { return };
        let chain = merged.profiles.chain(name);
        // A parent that could not be read may have it.
        if chain.is_empty() && !merged.family.incomplete {
            let names = || merged.names.iter().map(String::as_str);
            let error = Diagnostic::error("E0706", format!("unknown profile `{name}`"));
            self.sink.emit(match nearest(name, names()) {
                Some(near) => error.help(format!("did you mean `--profile {near}`?")),
                None => error.help(format!("the profiles of this spec are {}", listed(names()))),
            });
        }
        let root = Arc::make_mut(&mut merged.root);
        chain.into_iter().for_each(|map| merge(root, map, &self.forms));
    }

    /// The assignments of the command line, as trees.
    pub fn sets(&mut self) -> Vec<Map> {
        let (sources, sink) = (&mut self.sources, &mut self.sink);
        let parsed = self.options.sets.iter().filter_map(|argument| assignment(argument, sources, sink));
        let parsed: Vec<Map> = parsed.collect();
        unique(&parsed, sink);
        parsed.into_iter().filter(|map| settable(map, &mut self.sink)).collect()
    }

    /// Decodes a merged spec with its overlay.
    pub fn settle(&mut self, merged: &Merged, overlay: &Overlay<'_>) -> Experiment {
        let mut root = Map::clone(&merged.root);
        overlay.points.iter().for_each(|point| merge(&mut root, point, &self.forms));
        // It is only used to look up the values that assignments replace.
        let with_points = if overlay.sets.is_empty() { Map::default() } else { root.clone() };
        overlay.sets.iter().for_each(|map| merge(&mut root, map, &self.forms));
        let header = &merged.header;
        let mut decoder = Decoder::new(&mut self.sink);
        decoder.partial = merged.lenient();
        decoder.wordings = WORDINGS;
        let mut table = sections(&root, self.vocabulary, header, &mut decoder);
        let (marks, poisoned) = (decoder.marks, decoder.poisoned);
        let required = merged.family.members.iter().flat_map(|member| &member.header.requires);
        let child = requires::Child { root: &root, place: header.place, lenient: merged.lenient() };
        requires::check(required, &child, self.vocabulary, &mut self.sink);
        let place = header.place.unwrap_or(Span { source: SourceId(0), start: 0, end: 0 });
        table.insert("name".to_owned(), Value::Text(overlay.name.clone()));
        table.insert("summary".to_owned(), Value::Text(header.summary.clone()));
        let replaced = replaced(&marks, &[&merged.plain, &merged.root, &with_points], &self.sources);
        let mut experiment = Experiment {
            path: overlay.path.to_owned(),
            source: place.source,
            name: overlay.name.clone(),
            summary: header.summary.clone(),
            is_abstract: header.is_abstract,
            points: overlay.named.clone(),
            replaced,
            poisoned: poisoned.into_iter().collect(),
            compare: Vec::new(),
            baselines: Vec::new(),
            profile: self.options.profile.clone(),
            overlays: merged.profiles.clone(),
            profiles: merged.names.clone(),
            allow: allowed(&table),
            root: folder::root(self.files, overlay.path),
            reach: self.reach.clone(),
            robot: None,
            motion: None,
            table,
            marks,
        };
        experiment.table.remove(section::Header::allow.name);
        experiment.compare = compared(&experiment, &self.sources);
        experiment.baselines = baselines(&experiment, &self.sources);
        experiment.robot = self.attach(&experiment, "robot", "model", &robots(self.vocabulary));
        experiment.motion = self.attach(&experiment, "task", "motion", &motions(self.vocabulary));
        experiment
    }

    /// The file named by a key; each is read once.
    fn attach(
        &mut self,
        experiment: &Experiment,
        section: &str,
        key: &str,
        shelf: &Shelf<'_>,
    ) -> Option<Attachment> {
        let name = experiment.section(section)?.get(key)?.as_text()?;
        let place = experiment.marks.get(&below(section, key))?.value;
        let known = (shelf.folder, name.clone());
        if let Some(attachment) = self.attachments.get(&known) {
            return Some(attachment.clone());
        }
        let folder = folder::folder(self.files, &experiment.path);
        let project = Project { files: self.files, folder: &folder, reach: &self.reach };
        let found = shelf.find(name, place, &project, &mut self.sources, &mut self.sink)?;
        self.attachments.insert(known, found.clone());
        Some(found)
    }
}

/// Where robot files are found.
pub fn robots(vocabulary: &Vocabulary) -> Shelf<'_> {
    Shelf { noun: "robot", folder: "robots", code: "E0401", embedded: &vocabulary.robots }
}

/// Where motion files are found.
pub fn motions(vocabulary: &Vocabulary) -> Shelf<'_> {
    Shelf { noun: "motion", folder: "specs/motions", code: "E0304", embedded: &vocabulary.motions }
}

/// The values replaced by a profile or an assignment; trees in order of increasing priority.
fn replaced(marks: &Marks, below: &[&Map], sources: &Sources) -> BTreeMap<String, Vec<(Span, Layer)>> {
    // A table with a header is not a single value; an inline table is.
    let single = |node: &Node| {
        node.table().is_none()
            || sources
                .get(node.span.source)
                .text
                .get(node.span.start..)
                .is_some_and(|text| text.starts_with('{'))
    };
    let over = marks.by_path.iter().filter(|(_, mark)| mark.layer > Layer::File);
    let found = over.filter_map(|(path, mark)| {
        let mut places: Vec<(Span, Layer)> = Vec::new();
        for node in below
            .iter()
            .filter_map(|root| root.at(path))
            .filter(|node| node.layer < mark.layer && single(node))
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
    let Some(Value::Table(allow)) = table.get(section::Header::allow.name) else { return BTreeMap::new() };
    let texts = allow.iter().filter_map(|(code, reason)| match reason {
        Value::Text(reason) => Some((code.clone(), reason.clone())),
        _ => None,
    });
    texts.collect()
}

/// The specs of `report.compare`, relative to the file that names them.
fn compared(experiment: &Experiment, sources: &Sources) -> Vec<PathBuf> {
    let names = Section::new(&experiment.table).at(Report::compare).unwrap_or_default();
    let file = naming_file(experiment, &Report::compare.path(), sources);
    names.iter().map(|name| beside(file, name)).collect()
}

/// The specs of `report.baseline`, relative to the file that names them.
fn baselines(experiment: &Experiment, sources: &Sources) -> Vec<NamedSpec> {
    let names = match Section::new(&experiment.table).at(Report::baseline) {
        Some(Specs::One(name)) => vec![name],
        Some(Specs::Several(names)) => names,
        None => Vec::new(),
    };
    let path = Report::baseline.path();
    let file = naming_file(experiment, &path, sources);
    let named = |(place, name): (usize, String)| {
        let place = experiment.marks.nearest(&format!("{path}.{place}")).map(|mark| mark.value);
        NamedSpec { path: beside(file, &name), place }
    };
    names.into_iter().enumerate().map(named).collect()
}

/// The file that a key's paths are relative to: the one with the key, or the spec for an assignment.
fn naming_file<'a>(experiment: &'a Experiment, key: &str, sources: &'a Sources) -> &'a Path {
    match experiment.marks.get(key) {
        Some(mark) if mark.layer != Layer::Set => &sources.get(mark.value.source).name,
        _ => &experiment.path,
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "spec".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Sorts diagnostics by file and position; those without a place come first.
pub(super) fn sort(sink: &mut Sink) {
    sink.diagnostics
        .sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
}
