//! Named terms: tables whose kind defaults to their name, and which can be disabled.

use super::in_vain::assigned_in_vain;
use super::{Decoder, Registry, scalar};
use crate::diag::{Diagnostic, Span};
use crate::spec::marks::below;
use crate::spec::suggest::{nearest, safe_name};
use crate::spec::{Table, Value};
use crate::syntax::{Entry, Item, Map, Node};

/// Keys of a term that are decoded here.
pub const RESERVED: &[&str] = &["kind", "enabled"];

/// Maximum number of terms of a section; each is checked with every profile.
const MOST: usize = 1000;

/// Whether a name is valid for a term: in a path of `--set`, and as a bare TOML key.
fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
}

impl Decoder<'_> {
    /// Decodes named terms. Terms that are disabled or that failed are left out.
    pub fn terms(&mut self, node: &Node, registry: &Registry<'_>, path: &str) -> Option<Table> {
        let Some(map) = node.table() else {
            let message = format!("`{path}` must be a table of named terms, found {}", node.describe());
            self.sink.emit(Diagnostic::error("E0103", message).at(node.span, "not a table"));
            return None;
        };
        let mut terms = Table::new();
        if let Some(entry) = map.entries.values().nth(MOST) {
            let error = Diagnostic::error("E0009", format!("`{path}` has more than {MOST} terms"));
            self.sink.emit(error.at(entry.key, "one too many").help("remove terms"));
        }
        let section = path;
        for (name, entry) in map.entries.iter().take(MOST) {
            let path = below(section, name);
            self.mark(&path, entry.key, &entry.node);
            if !is_name(name) {
                let message = format!("invalid name `{name}` of a table in `[{section}]`");
                let error = Diagnostic::error("E0107", message).at(entry.key, "invalid name");
                let error = error.help("use letters, digits, `_` and `-`");
                let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
                let safe = safe_name(name, allowed).filter(|safe| !map.entries.contains_key(safe));
                self.sink.emit(match safe {
                    Some(safe) => error.fix(entry.key, safe),
                    None => error,
                });
                self.poisoned.insert(path);
                continue;
            }
            if name == "enabled" && entry.node.table().is_none() {
                let message =
                    format!("`[{section}]` cannot be switched off as a whole, only each {}", registry.noun);
                let error = Diagnostic::error("E0103", message).at(entry.key, "not a table");
                self.sink.emit(
                    error.help(format!("switch off each term with `{}.NAME.enabled = false`", section)),
                );
                self.poisoned.insert(path);
                continue;
            }
            match self.enabled(&entry.node, &path) {
                Some(true) => {
                    if let Some(term) = self.of_kind(&entry.node, registry, &path, Some((name, entry.key))) {
                        terms.insert(name.clone(), Value::Table(term));
                    }
                }
                Some(false) if self.is_news(&entry.node) => {
                    self.was_never_on(registry.noun, map, name, entry)
                }
                Some(false) => self.switched_off(&entry.node, registry, &path, Some((name, entry.key))),
                None => {}
            }
        }
        Some(terms)
    }

    /// Whether a table is enabled; `None` if the value is not a boolean.
    pub fn enabled(&mut self, node: &Node, path: &str) -> Option<bool> {
        match node.table().and_then(|map| map.get("enabled")).map(|node| (&node.item, node)) {
            None => Some(true),
            Some((Item::Flag(enabled), _)) => Some(*enabled),
            Some((_, node)) => {
                let message = format!("`enabled` takes `true` or `false`, found {}", node.describe());
                let error = Diagnostic::error("E0103", message).at(node.span, "wrong type");
                self.sink.emit(match scalar::flag_of(node) {
                    Some(flag) => error.help(format!("write `enabled = {flag}`")).fix(node.span, flag),
                    None => error,
                });
                self.poisoned.insert(path.to_owned());
                None
            }
        }
    }

    /// Checks a disabled table as if it were enabled, since a profile may enable it and a mistake is one
    /// either way. Only missing keys are allowed.
    pub fn switched_off(
        &mut self,
        node: &Node,
        registry: &Registry<'_>,
        path: &str,
        name: Option<(&str, Span)>,
    ) {
        // An abstract parent may disable a term that only its children define, so its kind is unknown here.
        let has_kind = node.table().is_some_and(|map| map.get("kind").is_some())
            || name.is_none_or(|(name, _)| registry.kinds.iter().any(|kind| kind.name == name));
        if self.partial && !has_kind {
            return;
        }
        let before = self.sink.diagnostics.len();
        let mut decoder = Decoder { partial: true, wordings: self.wordings, ..Decoder::new(&mut *self.sink) };
        decoder.of_kind(node, registry, path, name);
        if self.sink.diagnostics.len() == before {
            assigned_in_vain(node, path, self.sink);
        }
    }

    /// Whether only `enabled` is written and no parent defines the term.
    fn is_news(&self, node: &Node) -> bool {
        let is_switch = |key: &String| matches!(key.as_str(), "enabled" | "kind");
        !self.partial
            && node.table().is_some_and(|term| !term.inherited && term.entries.keys().all(is_switch))
    }

    /// Reports a term that is disabled but was never defined (E0605).
    fn was_never_on(&mut self, noun: &str, map: &Map, name: &str, entry: &Entry) {
        if self.sink.is_full("E0605") {
            return;
        }
        let others = map.entries.iter().filter(|(other, _)| *other != name).map(|(other, _)| other.as_str());
        let message = format!("no parent has a {noun} `{name}` to switch off");
        let error = Diagnostic::error("E0605", message).at(entry.key, "not inherited");
        self.sink.emit(match nearest(name, others) {
            Some(near) => error.help(format!("did you mean `{near}`?")).fix(entry.key, near),
            None => error.help("remove it"),
        });
    }
}
