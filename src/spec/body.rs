//! Decodes the sections of a merged spec.

use super::decode::{Decoder, Registry};
use super::family::Header;
use super::section::{self, SectionShape};
use super::suggest::{listed, nearest};
use super::synonyms;
use super::{Shape, Table, Value, Vocabulary};
use crate::diag::Diagnostic;
use crate::syntax::{Entry, Item, Layer, Map, Node};

/// Decodes all sections.
pub fn sections(root: &Map, vocabulary: &Vocabulary, header: &Header, decoder: &mut Decoder<'_>) -> Table {
    let mut table = Table::new();
    decoder.sections = vocabulary.sections.iter().map(|section| section.name).collect();
    for (key, entry) in &root.entries {
        if key == "allow" {
            decode_allow(entry, decoder, &mut table);
        } else if vocabulary.section(key).is_none() && !decoder.sink.is_full("E0102") {
            decoder.sink.emit(unknown_section(key, entry, vocabulary));
        }
    }
    for section in &vocabulary.sections {
        match root.entries.get(section.name) {
            Some(entry) => {
                decoder.mark(section.name, entry.key, &entry.node);
                if let Some(value) = decode_section(section, entry, decoder) {
                    table.insert(section.name.to_owned(), Value::Table(value));
                }
            }
            None if section.required => missing_section(section, header, decoder),
            None => absent_section(section, header, decoder, &mut table),
        }
    }
    table
}

fn decode_section(section: &SectionShape, entry: &Entry, decoder: &mut Decoder<'_>) -> Option<Table> {
    let registry = |kinds, extra, reserved| Registry { noun: section.noun, kinds, extra, reserved };
    match &section.shape {
        Shape::Plain(params) => decoder.plain(&entry.node, params, section.name),
        Shape::Kind(kinds) => {
            let reserved: &[&str] = if section.required { &["kind"] } else { &["kind", "enabled"] };
            if !section.required && !decoder.enabled(&entry.node, section.name)? {
                // A section with a single kind does not have to name it.
                let only = (kinds.len() == 1).then(|| (kinds[0].name, entry.key));
                decoder.switched_off(&entry.node, &registry(kinds, &[], reserved), section.name, only);
                return None;
            }
            decoder.of_kind(&entry.node, &registry(kinds, &[], reserved), section.name, None)
        }
        Shape::Terms(kinds, extra) => {
            decoder.terms(&entry.node, &registry(kinds, extra, &["kind", "enabled"]), section.name)
        }
    }
}

fn unknown_section(key: &str, entry: &Entry, vocabulary: &Vocabulary) -> Diagnostic {
    if section::Header::names().any(|name| name == key) {
        let error = Diagnostic::error("E0102", format!("`{key}` belongs to a file, not to a profile"));
        return error.at(entry.key, "").help("write it at the top of the file");
    }
    let names = || vocabulary.sections.iter().map(|section| section.name).chain(section::Header::names());
    let set = matches!(entry.node.layer, Layer::Point | Layer::Set);
    let what = if entry.node.table().is_some() { "section" } else { "key" };
    let error = match set {
        true => Diagnostic::error("E0604", format!("unknown path `{key}`")),
        false => Diagnostic::error("E0102", format!("unknown {what} `{key}`")),
    };
    let error = error.at(entry.key, "");
    let is_section = |(name, entry): &(&String, &Entry)| {
        entry.node.table().is_some() && vocabulary.sections.iter().any(|section| section.name == *name)
    };
    if let Some((own, _)) = entry.node.table().and_then(|map| map.entries.iter().find(is_section)) {
        return error.help(format!("`{own}` is a section of its own: write `{own}`, not `{key}.{own}`"));
    }
    let near = synonyms::here(key, "", names());
    let elsewhere = if near.is_none() { synonyms::elsewhere(key) } else { None };
    match near.or_else(|| nearest(key, names()).filter(|_| elsewhere.is_none())) {
        Some(near) => error.help(format!("did you mean `{near}`?")).fix(entry.key, near),
        None => {
            let mut names: Vec<&str> = vocabulary.sections.iter().map(|section| section.name).collect();
            names.sort_unstable();
            error.help(elsewhere.unwrap_or_else(|| format!("the sections are {}", listed(names))))
        }
    }
}

fn missing_section(section: &SectionShape, header: &Header, decoder: &mut Decoder<'_>) {
    decoder.poisoned.insert(section.name.to_owned());
    if decoder.partial {
        return;
    }
    let error = Diagnostic::error("E0101", format!("missing section `{}`", section.name));
    let error = match header.place {
        Some(place) => error.at(place, "neither in this spec nor in a parent"),
        None => error,
    };
    decoder.sink.emit(error.help(format!("add `[{}]`, or extend a spec that has it", section.name)));
}

/// An optional section that is missing has its defaults.
fn absent_section(section: &SectionShape, header: &Header, decoder: &mut Decoder<'_>, table: &mut Table) {
    let (Shape::Plain(params), Some(span)) = (&section.shape, header.place) else { return };
    let node = Node { span, layer: Layer::Default, item: Item::Table(Map::default()) };
    if let Some(value) = decoder.plain(&node, params, section.name) {
        table.insert(section.name.to_owned(), Value::Table(value));
    }
}

/// `[allow]`: warning codes, each with a reason.
fn decode_allow(entry: &Entry, decoder: &mut Decoder<'_>, table: &mut Table) {
    let Some(map) = entry.node.table() else {
        let message = format!("`allow` must be a table, found {}", entry.node.describe());
        decoder.sink.emit(Diagnostic::error("E0103", message).at(entry.node.span, "not a table"));
        return;
    };
    let mut allowed = Table::new();
    for (code, entry) in &map.entries {
        let warning = code.starts_with('W') && crate::diag::codes::page(code).is_some();
        match entry.node.text().map(str::trim) {
            _ if !warning => {
                let error = Diagnostic::error(
                    "E0102",
                    format!(
                        "`{code}` is not a \
                     warning"
                    ),
                )
                .at(entry.key, "");
                decoder.sink.emit(error.help("only warnings can be allowed: `W0501 = \"the reason\"`"));
            }
            Some(reason) if !reason.is_empty() => {
                allowed.insert(code.clone(), Value::Text(reason.to_owned()));
            }
            _ => {
                let error = Diagnostic::error("E0108", format!("missing reason for allowing `{code}`"));
                decoder
                    .sink
                    .emit(error.at(entry.node.span, "").help(format!("write `{code} = \"the reason\"`")));
            }
        }
    }
    table.insert("allow".to_owned(), Value::Table(allowed));
}
