//! Assignments of the command line and of a sweep's points: which are allowed.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::decode::derived;
use super::marks::below;
use crate::diag::{Diagnostic, Sink, Span};
use crate::syntax::Map;

/// Whether the assignments are allowed: derived values cannot be set.
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

/// Reports assignments of one path (E0104): one of them would be ignored.
pub(super) fn unique(sets: &[Map], sink: &mut Sink) {
    let mut first: BTreeMap<String, Span> = BTreeMap::new();
    for (path, place) in sets.iter().filter_map(assigned) {
        match first.entry(path) {
            Entry::Vacant(vacant) => drop(vacant.insert(place)),
            Entry::Occupied(found) => {
                let error = Diagnostic::error("E0104", format!("`{}` is set twice", found.key()));
                let error = error.at(place, "again here").note(*found.get(), "first set here");
                sink.emit(error.help("keep one of the two"));
            }
        }
    }
}

/// The path that an assignment sets, and its place.
fn assigned(map: &Map) -> Option<(String, Span)> {
    let (key, entry) = map.entries.first_key_value().filter(|_| map.entries.len() == 1)?;
    match entry.node.table().and_then(assigned) {
        Some((rest, end)) => Some((below(key, &rest), Span { start: entry.key.start, ..end })),
        None => Some((key.clone(), entry.key)),
    }
}
