//! W0505: keys of a parent that a changed `kind` dropped although the new kind has them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::family::{Family, Member};
use crate::spec::marks::below;
use crate::spec::{Experiment, Kind, Shape, Vocabulary};
use crate::syntax::{Entry, Layer, Map};

/// A child that changes `kind` must not silently replace a parent's value by a default.
pub fn lost_keys(experiment: &Experiment, family: &Family, vocabulary: &Vocabulary, sink: &mut Sink) {
    let members = &family.members;
    if members.len() < 2 {
        return;
    }
    for section in &vocabulary.sections {
        match &section.shape {
            Shape::Plain(_) => {}
            Shape::Kind(kinds) => look(experiment, section.name, kinds, members, sink),
            Shape::Terms(kinds, _) => {
                for name in names(section.name, members) {
                    look(experiment, &below(section.name, &name), kinds, members, sink);
                }
            }
        }
    }
}

/// The names of the terms of a section in any file.
fn names(section: &str, members: &[Arc<Member>]) -> Vec<String> {
    let tables = members.iter().filter_map(|member| table(&member.body, section));
    let mut names: Vec<String> = tables.flat_map(|table| table.entries.keys().cloned()).collect();
    names.sort();
    names.dedup();
    names
}

/// The table at a path.
fn table<'a>(body: &'a Map, path: &str) -> Option<&'a Map> {
    path.split('.').try_fold(body, |map, key| map.entries.get(key)?.node.table())
}

/// Goes through the files from parents to children and records what a change of kind drops.
fn look(
    experiment: &Experiment,
    path: &str,
    kinds: &[&'static Kind],
    members: &[Arc<Member>],
    sink: &mut Sink,
) {
    let mut kind: Option<String> = path.split_once('.').map(|(_, name)| name.to_owned());
    let mut written: BTreeMap<&str, &Entry> = BTreeMap::new();
    let mut lost: BTreeMap<&str, (&Entry, Span)> = BTreeMap::new();
    for table in members.iter().filter_map(|member| table(&member.body, path)) {
        let said = table
            .entries
            .get("kind")
            .and_then(|entry| Some((entry.node.text()?.to_owned(), entry.node.span)));
        if let Some((word, place)) = said {
            if kind.as_ref().is_some_and(|kind| *kind != word) {
                let dropped = std::mem::take(&mut written).into_iter();
                lost.extend(dropped.map(|(key, entry)| (key, (entry, place))));
            }
            kind = Some(word);
        }
        let keys = table.entries.iter().filter(|(key, _)| !matches!(key.as_str(), "kind" | "enabled"));
        written.extend(keys.map(|(key, entry)| (key.as_str(), entry)));
    }
    let Some(kind) = kinds.iter().find(|known| Some(known.name) == kind.as_deref()) else { return };
    if experiment.poisoned.binary_search_by(|poisoned| poisoned.as_str().cmp(path)).is_ok() {
        return;
    }
    for (key, (entry, place)) in lost {
        let (span, text) = (entry.key, entry.node.toml());
        let taken = kind.params.iter().any(|param| param.name == key);
        let now = experiment.marks.get(&below(path, key)).filter(|mark| mark.layer == Layer::Default);
        if let Some(mark) = now.filter(|mark| taken && mark.text != text) {
            let message =
                format!("the inherited `{path}.{key}` is lost because `kind` changes to `{}`", kind.name);
            let diagnostic = Diagnostic::warning("W0505", message).at(
                span,
                format!(
                    "replaced by the default, \
                     {}",
                    mark.text
                ),
            );
            let help = format!(
                "add `{key} = {text}` below `kind`, or `{key} = {}` to confirm the \
                                default",
                mark.text
            );
            sink.emit(diagnostic.note(place, "replaces the whole table").help(help));
        }
    }
}
