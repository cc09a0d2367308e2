//! Decodes the spanned tree into values by descriptors: fills in defaults, reports all mistakes and records
//! the place of every value. Used for spec files, robot files and motion files alike.
//!
//! A failed value is poisoned: its table is left out of the result, so that one cause gives one error.

mod choice;
mod in_vain;
mod keys;
mod misread;
mod relative;
mod sampler;
mod scalar;
mod terms;

use std::collections::{BTreeMap, BTreeSet};

use super::marks::{Mark, Marks, below};
use super::mistake::Wording;
use super::{Kind, Length, Param, Presence, Sampler, Table, Ty, Value};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::syntax::{Item, Layer, Map, Node};

pub use keys::derived;
pub use misread::part;

/// A decoded document and the places of its values.
#[derive(Clone, Debug, Default)]
pub struct Decoded {
    /// The values, defaults filled in.
    pub table: Table,
    /// Where they were written.
    pub marks: Marks,
}

/// Parses and decodes a document in `sources`, such as a robot file. `None` if anything is wrong with it; the
/// diagnostics are then in the sink.
pub fn document(
    sources: &Sources,
    source: SourceId,
    params: &'static [Param],
    sink: &mut Sink,
) -> Option<Decoded> {
    let node = crate::syntax::parse(sources, source, sink)?;
    table(&node, params, sink)
}

/// Decodes a table by its keys. `None` if anything is wrong with it.
pub fn table(node: &Node, params: &'static [Param], sink: &mut Sink) -> Option<Decoded> {
    let mut decoder = Decoder::new(sink);
    let table = decoder.plain(node, params, "")?;
    Some(Decoded { table, marks: decoder.marks })
}

/// [`table`] for an element of an array such as `[[claim]]`, whose keys have no headers.
pub fn element(node: &Node, params: &'static [Param], sink: &mut Sink) -> Option<Decoded> {
    let mut decoder = Decoder::new(sink);
    decoder.is_element = true;
    let table = decoder.plain(node, params, "")?;
    Some(Decoded { table, marks: decoder.marks })
}

/// Parses and decodes a document whose key `kind` names one of these kinds, such as a motion file.
pub fn document_of_kind(
    sources: &Sources,
    source: SourceId,
    kinds: &[&'static Kind],
    sink: &mut Sink,
) -> Option<Decoded> {
    let node = crate::syntax::parse(sources, source, sink)?;
    kind(&node, kinds, sink)
}

/// Decodes a table whose key `kind` names one of these kinds, such as a motion file.
pub fn kind(node: &Node, kinds: &[&'static Kind], sink: &mut Sink) -> Option<Decoded> {
    let mut decoder = Decoder::new(sink);
    let registry = Registry { noun: "motion", kinds, extra: &[], reserved: &["kind"] };
    let table = decoder.of_kind(node, &registry, "", None)?;
    Some(Decoded { table, marks: decoder.marks })
}

/// The default of a key; `None` for a key without one.
pub fn default_value(param: &Param) -> Option<Value> {
    let Presence::Default(text) = param.presence else { return None };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let nowhere = Span { source: sources.add("", ""), start: 0, end: 0 };
    Decoder::new(&mut sink).default(param, text, nowhere, param.name)
}

/// Whether a key is a list index.
fn is_index(key: &str) -> bool {
    !key.is_empty() && key.chars().all(|letter| letter.is_ascii_digit())
}

/// Whether a value of a type may be a table.
fn holds_tables(ty: &Ty) -> bool {
    match ty {
        Ty::Table(_) | Ty::Named(_) | Ty::Kind(_) | Ty::Terms(_) | Ty::Sampler(_) => true,
        Ty::OneOf(types) => types.iter().any(holds_tables),
        _ => false,
    }
}

/// The kinds allowed in a place.
#[derive(Clone, Copy, Debug)]
pub struct Registry<'a> {
    /// Their noun for messages: `reward term`.
    pub noun: &'a str,
    /// The kinds.
    pub kinds: &'a [&'static Kind],
    /// Keys that every kind of this place accepts.
    pub extra: &'static [Param],
    /// Keys decoded elsewhere: `kind`, and `enabled` where a table can be disabled.
    pub reserved: &'static [&'static str],
}

/// Decodes tables and records the places of their values.
pub struct Decoder<'a> {
    /// Receives the diagnostics.
    pub sink: &'a mut Sink,
    /// The places of all values so far.
    pub marks: Marks,
    /// Paths of tables that were left out because of an error.
    pub poisoned: BTreeSet<String>,
    /// Whether missing keys are allowed, as in an abstract parent.
    pub partial: bool,
    /// Whether to skip recording places, when only mistakes are of interest.
    pub without_marks: bool,
    /// Whether this is an element of an array of tables, whose keys have no headers.
    is_element: bool,
    /// Paths of tables whose missing keys have been reported already.
    pub told: BTreeSet<String>,
    /// Custom messages for particular keys.
    pub wordings: &'a [Wording],
    /// The sections of the document, which a table may hold by mistake.
    pub sections: Vec<&'static str>,
    /// Missing keys of list elements: the diagnostic for the first, and how many more it applies to.
    lacking: BTreeMap<String, Lack>,
}

/// Keys that several elements of a list lack.
struct Lack {
    /// Index of the diagnostic in the sink.
    told: usize,
    /// The message for the first element.
    message: String,
    /// Number of further elements.
    more: usize,
}

impl<'a> Decoder<'a> {
    /// A decoder with nothing decoded yet.
    pub fn new(sink: &'a mut Sink) -> Self {
        Self {
            sink,
            marks: Marks::default(),
            poisoned: BTreeSet::new(),
            partial: false,
            without_marks: false,
            is_element: false,
            told: BTreeSet::new(),
            wordings: &[],
            sections: Vec::new(),
            lacking: BTreeMap::new(),
        }
    }

    /// Decodes a table with these keys.
    pub fn plain(&mut self, node: &Node, params: &'static [Param], path: &str) -> Option<Table> {
        let map = self.expect_table(node, path, params)?;
        let place = keys::Place { path, header: node.span, kind: None, registry: None };
        self.fields(map, &[params], &place)
    }

    /// Decodes a table of a kind. The kind is given by the key `kind`, or by the table's own name with its
    /// place.
    pub fn of_kind(
        &mut self,
        node: &Node,
        registry: &Registry<'_>,
        path: &str,
        name: Option<(&str, Span)>,
    ) -> Option<Table> {
        let map = self.expect_table(node, path, &[])?;
        let kind = self.find_kind(map, node, registry, path, name)?;
        let place = keys::Place { path, header: node.span, kind: Some(kind), registry: Some(registry) };
        let mut table = self.fields(map, &[kind.params, registry.extra], &place)?;
        table.insert("kind".to_owned(), Value::Text(kind.name.to_owned()));
        if let Some(entry) = map.entries.get("kind") {
            self.mark(&below(path, "kind"), entry.key, &entry.node);
        } else if !self.without_marks {
            let mark = Mark {
                key: node.span,
                value: node.span,
                layer: node.layer,
                text: format!("\"{}\"", kind.name),
            };
            self.marks.by_path.insert(below(path, "kind"), mark);
        }
        Some(table)
    }

    /// Decodes the keys of a table; `None` if one of them failed.
    fn fields(&mut self, map: &Map, params: &[&'static [Param]], place: &keys::Place<'_>) -> Option<Table> {
        let mut table = Table::new();
        let (unknown, meant) = self.unknown_keys(map, params, place);
        let mut sound = unknown == 0;
        let mut missing = Vec::new();
        for param in params.iter().copied().flatten() {
            let path = below(place.path, param.name);
            let value = match (map.entries.get(param.name), param.presence) {
                (Some(entry), _) => {
                    self.mark(&path, entry.key, &entry.node);
                    self.value(&param.ty, &entry.node, param, &path)
                }
                (None, Presence::Optional) => continue,
                (None, Presence::Default(text)) => self.default(param, text, place.header, &path),
                // Its misspelling was reported already; fixing that adds the key.
                (None, Presence::Required) if meant.contains(param.name) => None,
                (None, Presence::Required) => {
                    missing.push(param);
                    None
                }
            };
            match value {
                Some(value) => {
                    table.insert(param.name.to_owned(), value);
                }
                None => sound = false,
            }
        }
        self.missing(&missing, map, place);
        if !sound {
            self.poisoned.insert(place.path.to_owned());
        }
        sound.then_some(table)
    }

    /// Decodes a default. It has no place of its own, so its place is the table that lacks the key.
    fn default(&mut self, param: &Param, text: &str, header: Span, path: &str) -> Option<Value> {
        let mut node =
            crate::syntax::parse_value(text, header.source, 0).expect("a descriptor's default is TOML");
        node.place(header);
        node.stamp(Layer::Default);
        self.mark(path, header, &node);
        self.value(&param.ty, &node, param, path)
    }

    /// Decodes a value of a type.
    fn value(&mut self, ty: &Ty, node: &Node, param: &Param, path: &str) -> Option<Value> {
        let result = match ty {
            Ty::List(item) => return self.list(item, node, param, path),
            Ty::Table(params) => {
                let params: &'static [Param] = params;
                return self.plain(node, params, path).map(Value::Table);
            }
            Ty::Named(item) => return self.named(item, node, param, path),
            Ty::Kind(kinds) => {
                let all = (kinds.all)();
                let registry = Registry { noun: kinds.noun, kinds: &all, extra: &[], reserved: &["kind"] };
                return self.of_kind(node, &registry, path, None).map(Value::Table);
            }
            Ty::Terms(kinds) => {
                let all = (kinds.all)();
                let registry =
                    Registry { noun: kinds.noun, kinds: &all, extra: &[], reserved: terms::RESERVED };
                return self.terms(node, &registry, path).map(Value::Table);
            }
            Ty::OneOf(types) => match choice::pick(types, node) {
                Some(ty) => return self.value(ty, node, param, path),
                None => Err(choice::mismatch(types, node, param.name)),
            },
            Ty::Sampler(dimension) => sampler::decode(*dimension, node, param),
            _ => scalar::decode(ty, node, param),
        };
        result.map_err(|diagnostic| self.sink.emit(diagnostic)).ok()
    }

    /// Decodes a list, item by item.
    fn list(&mut self, item: &Ty, node: &Node, param: &Param, path: &str) -> Option<Value> {
        let Item::List(items) = &node.item else {
            let expected = format!("`{}` takes a list, found {}", param.name, node.describe());
            let error = Diagnostic::error("E0103", expected).at(node.span, "not a list");
            let written = match (node.table(), item) {
                // Keys such as `hidden.0` are indices: the list was written as a table.
                (Some(map), _) if !map.entries.is_empty() && map.entries.keys().all(|key| is_index(key)) => {
                    let items: Vec<String> = map.entries.values().map(|entry| entry.node.toml()).collect();
                    format!("[{}]", items.join(", "))
                }
                (Some(_), item) if !holds_tables(item) => format!("[{}]", choice::example(item)),
                _ => format!("[{}]", node.toml()),
            };
            let error = if node.table().is_some() { error } else { error.fix(node.span, written.clone()) };
            self.sink.emit(error.help(format!("write `{} = {written}`", param.name)));
            return None;
        };
        if let Some(length) = param.length.filter(|length| !length.fits(items.len())) {
            self.sink.emit(wrong_length(length, items.len(), item, node, param));
            return None;
        }
        let mut values = Vec::with_capacity(items.len());
        for (index, node) in items.iter().enumerate() {
            let path = below(path, &index.to_string());
            self.mark(&path, node.span, node);
            values.push(self.value(item, node, param, &path));
        }
        values.into_iter().collect::<Option<Vec<_>>>().map(Value::List)
    }

    /// Decodes a table with user-defined keys.
    fn named(&mut self, item: &Ty, node: &Node, param: &Param, path: &str) -> Option<Value> {
        let map = self.expect_table(node, path, &[])?;
        let mut values = Vec::with_capacity(map.entries.len());
        for (name, entry) in &map.entries {
            let path = below(path, name);
            self.mark(&path, entry.key, &entry.node);
            values.push(self.value(item, &entry.node, param, &path).map(|value| (name.clone(), value)));
        }
        values.into_iter().collect::<Option<Table>>().map(Value::Table)
    }

    /// The node as a table with these keys, or E0103.
    fn expect_table<'n>(&mut self, node: &'n Node, path: &str, params: &[Param]) -> Option<&'n Map> {
        if node.table().is_none() {
            let message = format!("`{path}` must be a table, found {}", node.describe());
            let required = params.iter().filter(|param| matches!(param.presence, Presence::Required));
            let keys: Vec<String> =
                required.map(|param| format!("{} = {}", param.name, choice::example(&param.ty))).collect();
            let help = match self.is_element {
                true => format!("write a table: `{path} = {{ {} }}`", keys.join(", ")),
                false => format!("write a table: `[{path}]`"),
            };
            let error = Diagnostic::error("E0103", message).at(node.span, "not a table").help(help);
            // A term that is enabled or disabled like a flag.
            self.sink.emit(match (&node.item, path.contains('.')) {
                (Item::Flag(true), true) => error.fix(node.span, "{}"),
                (Item::Flag(false), true) => error.fix(node.span, "{ enabled = false }"),
                _ => error,
            });
            self.poisoned.insert(path.to_owned());
        }
        node.table()
    }

    /// Records the place of a value.
    pub fn mark(&mut self, path: &str, key: Span, node: &Node) {
        if self.without_marks {
            return;
        }
        let text = if is_single(node) { node.toml() } else { String::new() };
        let mark = Mark { key, value: node.span, layer: node.layer, text };
        self.marks.by_path.insert(path.to_owned(), mark);
    }
}

/// E0103 for a list with too few or too many items.
fn wrong_length(length: Length, found: usize, item: &Ty, node: &Node, param: &Param) -> Diagnostic {
    let found = if found == 0 { "none".to_owned() } else { found.to_string() };
    let message = format!("`{}` takes a list of {length}, found {found}", param.name);
    let form = |names: &[&str]| format!("write `{} = [{}]`", param.name, names.join(", "));
    let help = match length {
        Length::Some => {
            format!("write at least one, for example `{} = [{}]`", param.name, choice::example(item))
        }
        Length::Each(names) => form(names),
        Length::OneOrEach(names) => format!("{}, or one number for all", form(names)),
    };
    Diagnostic::error("E0103", message).at(node.span, "wrong length").help(help)
}

/// Whether a node is a single value, a distribution or a default, which is printed as one. The texts of whole
/// sections and of a robot's links are never needed.
fn is_single(node: &Node) -> bool {
    match &node.item {
        _ if node.layer == Layer::Default => true,
        Item::Table(map) => map.entries.keys().all(|key| Sampler::WORDS.contains(&key.as_str())),
        Item::List(items) => items.iter().all(is_single),
        _ => true,
    }
}

#[cfg(test)]
mod tests;
