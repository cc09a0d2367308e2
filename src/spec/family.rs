//! A spec and its parents: reads the files that `extends` names, once each, parents first.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::syntax::{Files, Forms, Item, Map, Node, file, files, merge, parse};

use super::Edition;

/// A file of the family.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its text.
    pub source: SourceId,
    /// What stands before its sections.
    pub header: Header,
    /// Its sections and profiles.
    pub body: Map,
}

/// The keys that belong to a file and are never inherited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Where the edition stands: the place for what the whole file lacks.
    pub place: Option<Span>,
    /// Its name, if it says one.
    pub name: Option<String>,
    /// What it is about.
    pub summary: String,
    /// Whether it is a parent that cannot be run.
    pub is_abstract: bool,
    /// Its parents, as written.
    pub extends: Vec<(String, Span)>,
}

/// A spec with its parents.
#[derive(Clone, Debug, Default)]
pub struct Family {
    /// Parents before children; the spec itself is the last.
    pub members: Vec<Member>,
    /// Whether a file could not be taken in, so that keys may be missing for that reason.
    pub incomplete: bool,
}

impl Family {
    /// Reads a spec and its parents. `None` when the spec itself cannot be read.
    pub fn gather(files: &dyn Files, path: &Path, sources: &mut Sources, sink: &mut Sink) -> Option<Self> {
        let text = file::read(files, path).map_err(|error| sink.emit(error)).ok()?;
        let mut gathering = Gathering { files, sources, sink, family: Self::default(), seen: BTreeSet::new() };
        gathering.take(path, text, &mut Vec::new()).then_some(gathering.family)
    }

    /// The spec's own header.
    pub fn header(&self) -> Header {
        self.members.last().map(|member| member.header.clone()).unwrap_or_default()
    }

    /// The sections and profiles of all members, merged.
    pub fn merged(&self, forms: &Forms) -> Map {
        let mut merged = Map::default();
        self.members.iter().for_each(|member| merge(&mut merged, &member.body, forms));
        merged
    }
}

struct Gathering<'a> {
    files: &'a dyn Files,
    sources: &'a mut Sources,
    sink: &'a mut Sink,
    family: Family,
    seen: BTreeSet<PathBuf>,
}

impl Gathering<'_> {
    /// Takes a file in, after its parents. `chain` is the way from the spec to this file.
    fn take(&mut self, path: &Path, text: String, chain: &mut Vec<(PathBuf, PathBuf)>) -> bool {
        let identity = self.files.identity(path);
        self.seen.insert(identity.clone());
        let source = self.sources.add(path, text);
        let Some(node) = parse(self.sources, source, self.sink) else { return false };
        let Item::Table(mut body) = node.item else { return false };
        let Some(header) = self.header(&mut body, source) else { return false };
        chain.push((identity, path.to_owned()));
        for (parent, place) in &header.extends {
            let complete = self.parent(path, (parent, *place), chain);
            self.family.incomplete |= !complete;
        }
        chain.pop();
        self.family.members.push(Member { source, header, body });
        true
    }

    /// Takes a parent in, unless it has been.
    fn parent(&mut self, child: &Path, (name, place): (&str, Span), chain: &mut Vec<(PathBuf, PathBuf)>) -> bool {
        let path = beside(child, name);
        let identity = self.files.identity(&path);
        if let Some(start) = chain.iter().position(|(known, _)| *known == identity) {
            let mut files: Vec<String> = chain[start..].iter().map(|(_, shown)| shown.display().to_string()).collect();
            files.push(files[0].clone());
            let error = Diagnostic::error("E0602", format!("a cycle of parents: {}", files.join(" -> ")));
            self.sink.emit(error.at(place, "closes the cycle").help("remove one of these `extends`"));
            return false;
        }
        if self.seen.contains(&identity) {
            return true;
        }
        match file::read(self.files, &path) {
            Ok(text) => self.take(&path, text, chain),
            Err(error) => {
                let code = if error.code == "E0004" { "E0601" } else { error.code };
                let message = match error.message.strip_prefix("file not found: ") {
                    Some(shown) => format!("parent not found: {shown}"),
                    None => error.message.clone(),
                };
                let error = Diagnostic { code, message, ..error };
                self.sink.emit(error.at(place, "named here, relative to this file"));
                false
            }
        }
    }

    /// Takes the header's keys out of a file. `None` when the file is of no edition that is known.
    fn header(&mut self, body: &mut Map, source: SourceId) -> Option<Header> {
        let top = Span { source, start: 0, end: 0 };
        let Some(edition) = body.entries.remove("spec") else {
            let error = Diagnostic::error("E0002", "the edition is missing").at(top, "every spec begins with it");
            self.sink.emit(error.help("add a first line `spec = 1`").fix(top, "spec = 1\n"));
            return None;
        };
        if !matches!(&edition.node.item, Item::Number(number) if number.whole == Some(i64::from(Edition::ONE.0))) {
            let message = format!("unsupported edition {}", edition.node.toml());
            let error = Diagnostic::error("E0003", message).at(edition.node.span, "this program knows edition 1");
            self.sink.emit(error.help("write `spec = 1`").fix(edition.node.span, "1"));
            return None;
        }
        let name = self.take_text(body, "name").filter(|(name, place)| self.check_name(name, *place));
        Some(Header {
            place: Some(edition.key),
            name: name.map(|(name, _)| name),
            summary: self.take_text(body, "summary").map(|(summary, _)| summary).unwrap_or_default(),
            is_abstract: self.take_flag(body, "abstract"),
            extends: self.take_extends(body),
        })
    }

    /// A name becomes a file name.
    fn check_name(&mut self, name: &str, place: Span) -> bool {
        let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'));
        let plain = plain && !name.starts_with('.');
        if !plain {
            let error =
                Diagnostic::error("E0107", format!("`{name}` is no name: reports and artefacts are called by it"));
            self.sink.emit(error.at(place, "not a name").help("use letters, digits, `_`, `-` and `.`"));
        }
        plain
    }

    fn wrong(&mut self, key: &str, expected: &str, node: &Node) {
        let error = Diagnostic::error("E0103", format!("`{key}` takes {expected}, found {}", node.describe()));
        self.sink.emit(error.at(node.span, "wrong type"));
    }

    fn take_text(&mut self, body: &mut Map, key: &str) -> Option<(String, Span)> {
        let node = body.entries.remove(key)?.node;
        match node.item {
            Item::Text(text) => Some((text, node.span)),
            _ => {
                self.wrong(key, "a text", &node);
                None
            }
        }
    }

    fn take_flag(&mut self, body: &mut Map, key: &str) -> bool {
        let Some(node) = body.entries.remove(key).map(|entry| entry.node) else { return false };
        if !matches!(node.item, Item::Flag(_)) {
            self.wrong(key, "`true` or `false`", &node);
        }
        node.item == Item::Flag(true)
    }

    fn take_extends(&mut self, body: &mut Map) -> Vec<(String, Span)> {
        let Some(node) = body.entries.remove("extends").map(|entry| entry.node) else { return Vec::new() };
        let items = match node.item {
            Item::List(items) => items,
            _ => vec![node],
        };
        let mut parents = Vec::with_capacity(items.len());
        for item in items {
            match &item.item {
                Item::Text(text) => parents.push((text.clone(), item.span)),
                _ => {
                    self.wrong("extends", "a path or a list of paths", &item);
                    self.family.incomplete = true;
                }
            }
        }
        parents
    }
}

/// A path that a file names, relative to the file; `..` is taken out where it can be.
pub fn beside(file: &Path, name: &str) -> PathBuf {
    files::plain(&file.parent().unwrap_or(Path::new("")).join(name))
}
