//! Loading: file and parents, profile, assignments, decoding, and the files that the spec names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::body::sections;
use super::decode::{Decoder, derived};
use super::family::{Family, Header, beside};
use super::marks::below;
use super::origin::origins;
use super::project::{self, Shelf};
use super::section::WORDINGS;
use super::suggest::{listed, nearest};
use super::{Attachment, Experiment, LoadOptions, Loaded, Marks, Table, Value, Vocabulary};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::syntax::assign::assignment;
use crate::syntax::{Disk, Entry, Files, Forms, Item, Layer, Map, Node, merge};

/// Loads a spec from the disk. Every mistake that can be found without knowing robots is in the sink.
pub fn load(path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    load_in(&Disk, path, options, vocabulary)
}

/// Loads a spec from any files.
pub fn load_in(files: &dyn Files, path: &Path, options: &LoadOptions, vocabulary: &Vocabulary) -> Loaded {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let Some(family) = Family::gather(files, path, &mut sources, &mut sink) else {
        return Loaded { sources, sink, ..Loaded::default() };
    };
    let experiment = experiment((files, path), &family, (options, vocabulary), (&mut sources, &mut sink));
    sort(&mut sink);
    Loaded { sources, sink, experiment: Some(experiment), family }
}

type Output<'a> = (&'a mut Sources, &'a mut Sink);

fn experiment(
    (files, path): (&dyn Files, &Path),
    family: &Family,
    (options, vocabulary): (&LoadOptions, &Vocabulary),
    (sources, sink): Output<'_>,
) -> Experiment {
    let forms = vocabulary.forms();
    let header = family.header();
    let mut root = family.merged(&forms);
    let profiles = take_profiles(&mut root, sink);
    let lenient = family.incomplete || header.is_abstract;
    let plain = root.clone();
    overlay_profile(&mut root, &profiles, options, &forms, sink);
    let with_profile = root.clone();
    for argument in &options.sets {
        if let Some(map) = assignment(argument, sources, sink).filter(|map| settable(map, sink)) {
            merge(&mut root, &map, &forms);
        }
    }
    let mut decoder = Decoder::new(sink);
    decoder.partial = lenient;
    decoder.wordings = WORDINGS;
    let mut table = sections(&root, vocabulary, &header, &mut decoder);
    let (marks, poisoned) = (decoder.marks, decoder.poisoned);
    check_other_profiles(&plain, &profiles, (options, &forms), (vocabulary, &header, lenient, &poisoned), sink);
    let place = header.place.unwrap_or(Span { source: crate::diag::SourceId(0), start: 0, end: 0 });
    let name = header.name.clone().unwrap_or_else(|| stem(path));
    table.insert("name".to_owned(), Value::Text(name.clone()));
    table.insert("summary".to_owned(), Value::Text(header.summary.clone()));
    let origins = origins(&table, &marks, sources, options.profile.as_deref());
    let replaced = replaced(&marks, &[&plain, &with_profile], sources);
    let mut experiment = Experiment {
        path: path.to_owned(),
        source: place.source,
        name,
        summary: header.summary,
        is_abstract: header.is_abstract,
        origins,
        replaced,
        poisoned: poisoned.into_iter().collect(),
        compare: Vec::new(),
        profile: options.profile.clone(),
        profiles: profiles.into_keys().collect(),
        allow: allowed(&table),
        root: project::root(files, path),
        robot: None,
        motion: None,
        table,
        marks,
    };
    experiment.table.remove("allow");
    experiment.compare = compared(&experiment, sources);
    experiment.robot = attach(&experiment, ("robot", "model"), (files, &robots(vocabulary)), (sources, sink));
    experiment.motion = attach(&experiment, ("task", "motion"), (files, &motions(vocabulary)), (sources, sink));
    experiment
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

/// Reports what is wrong only with a profile, when none is chosen: it would surprise later.
fn check_other_profiles(
    root: &Map,
    profiles: &BTreeMap<String, Entry>,
    (options, forms): (&LoadOptions, &Forms),
    (vocabulary, header, lenient, poisoned): (&Vocabulary, &Header, bool, &BTreeSet<String>),
    sink: &mut Sink,
) {
    let others = profiles.iter().filter(|_| options.profile.is_none());
    for map in others.filter_map(|(_, entry)| entry.node.table()) {
        let mut root = root.clone();
        merge(&mut root, map, forms);
        let mut found = Sink::default();
        let mut decoder = Decoder::new(&mut found);
        decoder.partial = lenient;
        decoder.told = poisoned.clone();
        decoder.wordings = WORDINGS;
        sections(&root, vocabulary, header, &mut decoder);
        for diagnostic in found.diagnostics {
            if !sink.diagnostics.contains(&diagnostic) {
                sink.emit(diagnostic);
            }
        }
    }
}

/// Whether an assignment may be made: what is derived cannot be set.
fn settable(map: &Map, sink: &mut Sink) -> bool {
    let (mut path, mut map) = (String::new(), map);
    while let Some((key, entry)) = map.entries.first_key_value() {
        path = below(&path, key);
        if let Some(error) = derived(&path, entry) {
            sink.emit(error);
            return false;
        }
        match entry.node.table() {
            Some(below) => map = below,
            None => break,
        }
    }
    true
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
fn compared(experiment: &Experiment, sources: &Sources) -> Vec<std::path::PathBuf> {
    let Some(report) = experiment.section("report") else { return Vec::new() };
    let file = experiment.marks.get("report.compare").map(|mark| (mark.layer, &sources.get(mark.value.source).name));
    let file = match file {
        Some((Layer::Set, _)) | None => &experiment.path,
        Some((_, file)) => file,
    };
    report.texts("compare").iter().map(|name| beside(file, name)).collect()
}

/// The file that a key names.
fn attach(
    experiment: &Experiment,
    (section, key): (&str, &str),
    (files, shelf): (&dyn Files, &Shelf<'_>),
    output: Output<'_>,
) -> Option<Attachment> {
    let name = experiment.section(section)?.text_if(key)?;
    let place = experiment.marks.get(&below(section, key))?.value;
    shelf.find(name, place, (files, experiment.root.as_deref()), output)
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "spec".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Orders diagnostics by file and place; what has no place comes first.
fn sort(sink: &mut Sink) {
    sink.diagnostics.sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
}
