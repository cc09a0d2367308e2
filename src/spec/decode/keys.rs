//! Keys: unknown, missing, belonging to another kind, and the kind itself.

use std::collections::BTreeSet;

use super::choice::{blank, describe};
use super::{Decoder, Lack, Registry};
use crate::diag::{Diagnostic, MOST_OF_A_CODE, Span};
use crate::spec::marks::below;
use crate::spec::mistake::{DERIVED, Wording};
use crate::spec::suggest::{listed, nearest};
use crate::spec::synonyms;
use crate::spec::{Edition, Kind, Param, Ty};
use crate::syntax::{Entry, Item, Layer, Map, Node};

/// The table whose keys are checked.
pub struct Place<'a> {
    /// Its path.
    pub path: &'a str,
    /// Where it is in the text.
    pub header: Span,
    /// Its kind, if tables of this place have one.
    pub kind: Option<&'static Kind>,
    /// The registry of its kind.
    pub registry: Option<&'a Registry<'a>>,
}

impl Decoder<'_> {
    fn wording(&self, place: &Place<'_>, key: &str) -> Option<Wording> {
        let kind = place.kind.map_or("", |kind| kind.name);
        let fits = |wording: &&Wording| {
            wording.path == place.path
                && wording.key == key
                && (wording.kind.is_empty() || wording.kind == kind)
        };
        self.wordings.iter().find(fits).copied()
    }

    /// Reports unknown keys with suggestions and returns their number.
    pub(super) fn unknown_keys(
        &mut self,
        map: &Map,
        params: &[&'static [Param]],
        place: &Place<'_>,
    ) -> (usize, BTreeSet<&'static str>) {
        let reserved = place.registry.map_or(&[] as &[&str], |registry| registry.reserved);
        let (mut unknown, mut meant) = (0, BTreeSet::new());
        for (key, entry) in &map.entries {
            let known = params.iter().copied().flatten().any(|param| param.name == key);
            // One more than the limit, so that a note mentions the rest.
            if !known && unknown > MOST_OF_A_CODE {
                unknown += 1;
            } else if !known && !reserved.contains(&key.as_str()) {
                // A key that the table already has is not suggested.
                let is_written = |name: &str| {
                    map.entries.get(name).is_some_and(|other| {
                        other.key.source == entry.key.source && other.node.layer == entry.node.layer
                    })
                };
                let names = || params.iter().copied().flatten().map(|param| param.name);
                let all: Vec<&str> = names().chain(reserved.iter().copied()).collect();
                let free: Vec<&str> = all.iter().copied().filter(|name| !is_written(name)).collect();
                let diagnostic = self.unknown_key(key, entry, map, all, &free, place);
                meant.extend(range_of(key, entry, map, place));
                meant.extend(
                    nearest(key, names().filter(|name| free.contains(name)))
                        .filter(|_| matches!(diagnostic.code, "E0102" | "E0604")),
                );
                // For a key of another kind, point to where the kind is set.
                let said = map.entries.get("kind").filter(|_| matches!(diagnostic.code, "E0105" | "E0503"));
                self.sink.emit(match said {
                    Some(kind) => diagnostic.note(kind.node.span, "the kind"),
                    None => diagnostic,
                });
                unknown += 1;
            }
        }
        (unknown, meant)
    }

    /// `free`: those of the names that the table does not have yet.
    fn unknown_key(
        &self,
        key: &str,
        entry: &Entry,
        map: &Map,
        names: Vec<&str>,
        free: &[&str],
        place: &Place<'_>,
    ) -> Diagnostic {
        if let Some(wording) = self.wording(place, key) {
            return Diagnostic::error(wording.code, wording.message).at(entry.key, "").help(wording.help);
        }
        let path = below(place.path, key);
        if let Some(error) = derived(&path, entry) {
            return error;
        }
        let synonym = synonyms::here(key, place.path, free.iter().copied());
        let elsewhere = if synonym.is_none() { synonyms::elsewhere(key) } else { None };
        let near = synonym.or_else(|| nearest(key, free.iter().copied())).filter(|_| elsewhere.is_none());
        let owners = if near.is_none() { owners(key, place) } else { Vec::new() };
        if matches!(entry.node.layer, Layer::Point | Layer::Set) && owners.is_empty() {
            let error = Diagnostic::error("E0604", format!("unknown path `{path}`")).at(entry.key, "");
            return match near {
                Some(name) => {
                    error.help(format!("did you mean `{}`?", below(place.path, name))).fix(entry.key, name)
                }
                None => match elsewhere {
                    Some(help) => error.help(help),
                    None => error.help(format!("the keys of `{}` are {}", place.path, listed(sorted(names)))),
                },
            };
        }
        if !owners.is_empty() {
            return foreign_key(key, entry, &owners, place);
        }
        let whole = if place.path.is_empty() { String::new() } else { format!(" in `{}`", place.path) };
        let error = Diagnostic::error("E0102", format!("unknown key `{key}`{whole}")).at(entry.key, "");
        // A range needs more than the other name: its value becomes a distribution.
        let is_free = near.is_none() || synonym.is_some();
        if let Some(sampled) = range_of(key, entry, map, place).filter(|_| is_free) {
            let word = if key == "normal" { "normal" } else { "uniform" };
            let written = format!("{sampled} = {{ {word} = {} }}", entry.node.toml());
            let span = Span { end: entry.node.span.end, ..entry.key };
            return error.help(format!("write `{written}`")).fix(span, written);
        }
        match near {
            Some(name) => error.help(format!("did you mean `{name}`?")).fix(entry.key, name),
            None if elsewhere.is_some() => error.help(elsewhere.unwrap_or_default()),
            None if !place.path.is_empty() && self.sections.contains(&key) => {
                error.help(format!("it is a section of its own: write `{key}`, not `{path}`"))
            }
            None if names.is_empty() => error.help("remove it: this table has no keys"),
            None if free.is_empty() => {
                error.help(format!("remove it: the valid keys are {}", listed(sorted(names))))
            }
            None => error.help(format!("the valid keys are {}", listed(sorted(names)))),
        }
    }

    /// Reports all missing keys of a table at once (E0101).
    pub(super) fn missing(&mut self, params: &[&Param], map: &Map, place: &Place<'_>) {
        if self.partial || params.is_empty() || self.told.contains(place.path) {
            return;
        }
        let names = || params.iter().map(|param| param.name);
        let wording = self.wordings.iter().find(|wording| {
            names().any(|name| name == wording.key)
                && self.wording(place, wording.key).is_some_and(|found| found == **wording)
        });
        let mut error = match (wording, params) {
            (Some(wording), [_]) => {
                let message = format!("{}: {} is missing", wording.message, listed(names()));
                Diagnostic::error(wording.code, message).at(place.header, "").help(wording.help)
            }
            (Some(wording), _) => {
                let message = format!("{}: {} are missing", wording.message, listed(names()));
                let error = Diagnostic::error(wording.code, message).at(place.header, "");
                let own = |param: &&Param| self.wording(place, param.name);
                let others: Vec<&Param> =
                    params.iter().filter(|param| own(param).is_none()).copied().collect();
                let error =
                    if others.is_empty() { error } else { error.help(lines_to_add(&others, map, place)) };
                params.iter().filter_map(own).fold(error, |error, wording| error.help(wording.help))
            }
            (None, [param]) => {
                let message = format!("missing key `{}`{}", param.name, whole(place));
                let label = format!("`{}` is missing: {}", param.name, describe(&param.ty));
                Diagnostic::error("E0101", message)
                    .at(place.header, label)
                    .help(lines_to_add(params, map, place))
            }
            (None, _) => {
                let message = format!("missing keys {}{}", listed(names()), whole(place));
                Diagnostic::error("E0101", message)
                    .at(place.header, "")
                    .help(lines_to_add(params, map, place))
            }
        };
        let dropped = names().filter_map(|name| map.replaced.get(name));
        for (index, (span, _)) in dropped.enumerate() {
            let words =
                if index == 0 { "dropped: another `kind` replaces the whole table" } else { "dropped" };
            error = error.note(*span, words);
        }
        self.emit_once(error, place.path);
    }

    /// Keys missing in several elements of a list are reported once, at the first element, with a count:
    /// twelve joints are one mistake.
    fn emit_once(&mut self, error: Diagnostic, path: &str) {
        let Some((list, any)) = element(path) else { return self.sink.emit(error) };
        let same = error.message.replace(&format!("`{path}`"), &format!("`{any}`"));
        match self.lacking.get_mut(&same) {
            Some(lack) => {
                lack.more += 1;
                let message = format!("{} and in {} more of `{list}`", lack.message, lack.more);
                self.sink.diagnostics[lack.told].message = message;
            }
            None if self.sink.is_full(error.code) => {}
            None => {
                let lack =
                    Lack { told: self.sink.diagnostics.len(), message: error.message.clone(), more: 0 };
                self.lacking.insert(same, lack);
                self.sink.emit(error);
            }
        }
    }

    /// The kind of a table.
    pub(super) fn find_kind(
        &mut self,
        map: &Map,
        node: &Node,
        registry: &Registry<'_>,
        path: &str,
        name: Option<(&str, Span)>,
    ) -> Option<&'static Kind> {
        let kinds = || registry.kinds.iter().map(|kind| kind.name);
        let (word, at) = match (map.entries.get("kind"), name) {
            (Some(entry), _) => match entry.node.text() {
                Some(word) => (word, entry.node.span),
                None => {
                    let message = format!("`kind` must be a string, found {}", entry.node.describe());
                    self.sink.emit(Diagnostic::error("E0103", message).at(entry.node.span, "wrong type"));
                    self.poisoned.insert(path.to_owned());
                    return None;
                }
            },
            (None, Some(name)) => name,
            (None, None) => {
                if !self.partial {
                    let error = Diagnostic::error("E0101", format!("missing key `kind` in `{path}`"));
                    let help = format!("the kinds of {} are {}", registry.noun, listed(kinds()));
                    self.sink.emit(error.at(node.span, "`kind` is missing").help(help));
                }
                self.poisoned.insert(path.to_owned());
                return None;
            }
        };
        let found = registry.kinds.iter().find(|kind| kind.name == word).copied();
        if found.is_none() && self.sink.is_full("E0301") {
            self.poisoned.insert(path.to_owned());
            return None;
        }
        let error = match found {
            Some(kind) if kind.since <= Edition::ONE => return Some(kind),
            Some(kind) => {
                let message = format!("kind `{word}` needs edition {}", kind.since.0);
                Diagnostic::error("E0302", message).at(at, "").help("this spec is written in edition 1")
            }
            None => {
                let set = node.layer == Layer::Set && !map.entries.contains_key("kind");
                let message = match set {
                    true => format!("unknown path `{path}`"),
                    false => format!("unknown {} `{word}`", registry.noun),
                };
                let error = Diagnostic::error(if set { "E0604" } else { "E0301" }, message).at(at, "");
                let section = path.split('.').next().unwrap_or_default();
                match synonyms::here(word, section, kinds()).or_else(|| nearest(word, kinds())) {
                    Some(kind) if map.entries.contains_key("kind") => {
                        error.help(format!("did you mean `{kind}`?")).fix(at, format!("\"{kind}\""))
                    }
                    Some(kind) => error.help(format!("did you mean `{kind}`?")).fix(at, kind),
                    None => error.help(format!("the kinds are {}", listed(kinds()))),
                }
            }
        };
        self.sink.emit(error);
        self.poisoned.insert(path.to_owned());
        None
    }
}

/// The key that a range such as `range = [0.5, 1.25]` probably belongs to: the kind's only key that takes a
/// distribution, if this file does not set it.
fn range_of(key: &str, entry: &Entry, map: &Map, place: &Place<'_>) -> Option<&'static str> {
    let is_range = matches!(key, "range" | "bounds" | "limits" | "uniform" | "normal")
        && matches!(&entry.node.item, Item::List(items) if items.len() == 2)
        && entry.key.source == entry.node.span.source
        && entry.key.end <= entry.node.span.start;
    let mut sampled = place.kind?.params.iter().filter(|param| matches!(param.ty, Ty::Sampler(_)));
    // A value inherited from a parent may be replaced, one of the same file may not.
    let is_free = |name: &str| map.get(name).is_none_or(|node| node.span.source != entry.key.source);
    match (sampled.next(), sampled.next()) {
        (Some(param), None) if is_range && is_free(param.name) => Some(param.name),
        _ => None,
    }
}

/// E0603 for a value that is derived.
pub fn derived(path: &str, entry: &Entry) -> Option<Diagnostic> {
    let (_, from) = DERIVED.iter().find(|(derived, _)| *derived == path)?;
    let error = Diagnostic::error("E0603", format!("`{path}` cannot be set"));
    Some(error.at(entry.key, format!("computed from {from}")).help("remove it"))
}

/// The list in a path, and the path for any of its elements: `links` and `links.*.joint`.
fn element(path: &str) -> Option<(String, String)> {
    let parts: Vec<&str> = path.split('.').collect();
    let index = parts.iter().position(|part| part.bytes().all(|letter| letter.is_ascii_digit()))?;
    let mut any = parts.clone();
    any[index] = "*";
    Some((parts[..index].join("."), any.join(".")))
}

/// The table that lacks keys, for messages.
fn whole(place: &Place<'_>) -> String {
    match (place.path, place.kind) {
        ("", _) => String::new(),
        (path, Some(kind)) if !path.ends_with(kind.name) => format!(" in `{path}` of kind `{}`", kind.name),
        (path, _) => format!(" in `{path}`"),
    }
}

/// Advice with a line for each missing key. A parent's value, even of another kind, is the best guess.
fn lines_to_add(params: &[&Param], map: &Map, place: &Place<'_>) -> String {
    let value = |param: &Param| {
        map.replaced.get(param.name).map_or_else(|| blank(&param.ty), |(_, text)| text.clone())
    };
    let lines: Vec<String> =
        params.iter().map(|param| format!("{} = {}", param.name, value(param))).collect();
    // Keys within the table's own span mean that it is written inline, in braces.
    let within = |entry: &Entry| {
        let (table, key) = (place.header, entry.key);
        table.source == key.source && table.start <= key.start && key.end <= table.end
    };
    if !map.entries.is_empty() && map.entries.values().all(within) {
        return format!("add {} between the braces", listed(lines.iter().map(String::as_str)));
    }
    match lines.as_slice() {
        [line] => format!("add the line `{line}`"),
        _ => format!("add the lines {}", listed(lines.iter().map(String::as_str))),
    }
}

/// The other kinds of the registry with this key.
fn owners(key: &str, place: &Place<'_>) -> Vec<&'static str> {
    let kinds = place.registry.map_or(&[] as &[&Kind], |registry| registry.kinds);
    kinds
        .iter()
        .filter(|kind| kind.params.iter().any(|param| param.name == key))
        .map(|kind| kind.name)
        .collect()
}

/// E0105: a key that only other kinds have.
fn foreign_key(key: &str, entry: &Entry, owners: &[&'static str], place: &Place<'_>) -> Diagnostic {
    let this = place.kind.map_or("", |kind| kind.name);
    let own = place.kind.map_or(&[] as &[Param], |kind| kind.params);
    let message = match owners {
        [owner] => format!("`{key}` is a key of kind `{owner}`, not of `{this}`"),
        _ => format!("`{key}` is a key of other kinds, not of `{this}`"),
    };
    let error = Diagnostic::error("E0105", message).at(entry.key, format!("unknown to `{this}`"));
    let taken = match own.len() {
        0 => format!("`{this}` takes no keys of its own"),
        _ => format!("the keys of `{this}` are {}", listed(own.iter().map(|param| param.name))),
    };
    match owners {
        [owner] => error.help(format!("remove it, or write `kind = \"{owner}\"`")),
        _ => error.help(format!("remove it; {taken}")),
    }
}

fn sorted(mut names: Vec<&str>) -> Vec<&str> {
    names.sort_unstable();
    names
}
