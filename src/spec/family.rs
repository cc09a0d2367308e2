//! A spec and its parents: reads each file named by `extends` once, parents first.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::escape;
use crate::syntax::{Files, Forms, Item, Map, Node, file, files, merge, parse};

use super::Edition;
use super::reach::{Place, Reach};
use super::requires::{self, Required};
use super::section;
use super::section::Report;
use super::suggest::{is_file_name, safe_name};
use super::typed::InSection;

/// Maximum length of a chain of parents.
const MOST_GENERATIONS: usize = 32;
/// Maximum length of a spec's name in bytes. File names consist of it, endings and the profile's name, and
/// file systems allow 255.
pub const LONGEST_NAME: usize = 120;
/// Maximum number of parents of a spec.
const MOST_PARENTS: usize = 500;

/// A file of the family.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its text.
    pub source: SourceId,
    /// The keys before its sections.
    pub header: Header,
    /// Its sections and profiles.
    pub body: Map,
}

/// The keys that belong to a file and are never inherited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Place of the edition, where keys missing from the whole file are reported.
    pub place: Option<Span>,
    /// Its name, if present: `name`, or `suite` of a suite.
    pub name: Option<String>,
    /// Place of `suite`, if the file is a suite.
    pub suite: Option<Span>,
    /// A one-sentence summary.
    pub summary: String,
    /// Whether it is an abstract parent, which cannot be run.
    pub is_abstract: bool,
    /// Its parents, as written.
    pub extends: Vec<(String, Span)>,
    /// The keys that it requires of the specs that extend it.
    pub requires: Vec<Required>,
    /// Whether the name of a parent is invalid.
    pub lost_parent: bool,
}

/// A spec with its parents.
#[derive(Clone, Debug, Default)]
pub struct Family {
    /// Parents before children; the spec itself is the last.
    pub members: Vec<Arc<Member>>,
    /// Whether a file could not be read, so that keys may be missing for that reason.
    pub incomplete: bool,
}

/// The files read so far, each parsed once however many specs extend it. Failures are remembered too, so that
/// they are reported once.
#[derive(Clone, Debug, Default)]
pub struct Library {
    members: BTreeMap<PathBuf, Option<Arc<Member>>>,
}

/// Inputs and outputs of reading a family.
pub struct Desk<'a> {
    /// Where files are.
    pub files: &'a dyn Files,
    /// Which of them may be read.
    pub reach: &'a Reach,
    /// The files so far.
    pub library: &'a mut Library,
    /// The texts.
    pub sources: &'a mut Sources,
    /// The diagnostics.
    pub sink: &'a mut Sink,
}

impl Library {
    /// A spec's own file, without its parents. `None` when it cannot be read.
    pub fn own(path: &Path, desk: &mut Desk<'_>) -> Option<Arc<Member>> {
        let text = file::read(desk.files, path).map_err(|error| desk.sink.emit(error)).ok()?;
        let mut gathering = Gathering { desk, family: Family::default(), seen: BTreeSet::new() };
        let identity = gathering.desk.files.identity(path);
        gathering.member(path, identity, text)
    }
}

impl Family {
    /// Reads a spec and its parents. `None` if the spec itself cannot be read.
    pub fn gather(path: &Path, desk: &mut Desk<'_>) -> Option<Self> {
        let text = file::read(desk.files, path).map_err(|error| desk.sink.emit(error)).ok()?;
        let mut gathering = Gathering { desk, family: Self::default(), seen: BTreeSet::new() };
        let identity = gathering.desk.files.identity(path);
        let member = gathering.member(path, identity.clone(), text)?;
        gathering.take(path, identity, member, &mut Vec::new());
        Some(gathering.family)
    }

    /// The parents named by a file and their parents, without the file itself.
    pub fn of_parents(path: &Path, parents: &[(String, Span)], desk: &mut Desk<'_>) -> Self {
        let mut gathering = Gathering { desk, family: Self::default(), seen: BTreeSet::new() };
        let mut chain = vec![(gathering.desk.files.identity(path), path.to_owned())];
        gathering.parents(path, parents, &mut chain);
        gathering.family
    }

    /// The spec's own header.
    pub fn header(&self) -> Header {
        self.members.last().map(|member| member.header.clone()).unwrap_or_default()
    }

    /// The sections and profiles of all members, merged; without what parents say of their own report.
    pub fn merged(&self, forms: &Forms) -> Map {
        let mut merged = Map::default();
        let Some((own, parents)) = self.members.split_last() else { return merged };
        parents.iter().for_each(|parent| merge(&mut merged, &parent.body, forms));
        let report = merged.entries.get_mut(Report::SECTION).and_then(|entry| entry.node.table_mut());
        if let Some(report) = report {
            report
                .entries
                .retain(|key, _| ![Report::question.name, Report::reasons.name].contains(&key.as_str()));
        }
        merge(&mut merged, &own.body, forms);
        merged
    }
}

struct Gathering<'a, 'd> {
    desk: &'a mut Desk<'d>,
    family: Family,
    seen: BTreeSet<PathBuf>,
}

/// The chain from the spec to a file: canonical and displayed paths.
type Chain = Vec<(PathBuf, PathBuf)>;

impl Gathering<'_, '_> {
    /// Adds a file after its parents.
    fn take(&mut self, path: &Path, identity: PathBuf, member: Arc<Member>, chain: &mut Chain) {
        self.seen.insert(identity.clone());
        chain.push((identity, path.to_owned()));
        self.parents(path, &member.header.extends, chain);
        chain.pop();
        self.family.incomplete |= member.header.lost_parent;
        self.family.members.push(member);
    }

    /// Adds a parent after its own; false for a suite (E0606).
    fn take_spec(
        &mut self,
        path: &Path,
        identity: PathBuf,
        member: Arc<Member>,
        place: Span,
        chain: &mut Chain,
    ) -> bool {
        if member.header.suite.is_some() {
            let message = format!("`{}` is a suite, and parents are specs", escape::file(path));
            let error = Diagnostic::error("E0606", message).at(place, "named here");
            self.desk.sink.emit(error.help("name one of the specs that the suite varies"));
            return false;
        }
        self.take(path, identity, member, chain);
        true
    }

    fn parents(&mut self, path: &Path, parents: &[(String, Span)], chain: &mut Chain) {
        if let Some((_, place)) = parents.get(MOST_PARENTS) {
            let error = Diagnostic::error("E0109", format!("a spec has at most {MOST_PARENTS} parents"));
            self.desk.sink.emit(error.at(*place, "one parent too many").help("merge parents into one file"));
            self.family.incomplete = true;
        }
        for (parent, place) in parents.iter().take(MOST_PARENTS) {
            let complete = self.parent(path, parent, *place, chain);
            self.family.incomplete |= !complete;
        }
    }

    /// A file from its text, parsed the first time.
    fn member(&mut self, path: &Path, identity: PathBuf, text: String) -> Option<Arc<Member>> {
        if let Some(known) = self.desk.library.members.get(&identity) {
            return known.clone();
        }
        let member = self.parsed(path, text).map(Arc::new);
        self.desk.library.members.insert(identity, member.clone());
        member
    }

    fn parsed(&mut self, path: &Path, text: String) -> Option<Member> {
        let node = match self.desk.reach.place(self.desk.files, path) == Place::Allowed {
            true => self.private(path, text)?,
            false => {
                let source = self.desk.sources.add(path, text);
                parse(self.desk.sources, source, self.desk.sink)?
            }
        };
        let source = node.span.source;
        let Item::Table(mut body) = node.item else { return None };
        let header = self.header(&mut body, source)?;
        Some(Member { source, header, body })
    }

    /// The tree of a file outside the project, which messages do not quote; of invalid TOML only the position
    /// is reported.
    fn private(&mut self, path: &Path, text: String) -> Option<Node> {
        let source = self.desk.sources.add_private(path, text);
        let mut found = Sink::default();
        let node = parse(self.desk.sources, source, &mut found);
        if let (None, Some(first)) = (&node, found.diagnostics.first()) {
            let error = Diagnostic::error("E0001", "TOML syntax: the file is not valid TOML");
            self.desk.sink.emit(first.labels.iter().fold(error, |error, label| error.at(label.span, "")));
        }
        node
    }

    /// Adds a parent unless it was added already.
    fn parent(&mut self, child: &Path, name: &str, place: Span, chain: &mut Chain) -> bool {
        let path = beside(child, name);
        if let Some(refusal) = self.desk.reach.refusal(self.desk.files, &path) {
            self.desk.sink.emit(refusal.at(place, "not read"));
            return false;
        }
        let identity = self.desk.files.identity(&path);
        if let Some(start) = chain.iter().position(|(known, _)| *known == identity) {
            let mut files: Vec<String> =
                chain[start..].iter().map(|(_, shown)| shown.display().to_string()).collect();
            files.push(files[0].clone());
            let error = Diagnostic::error("E0602", format!("a cycle of parents: {}", files.join(" -> ")));
            self.desk.sink.emit(error.at(place, "closes the cycle").help("remove one of these `extends`"));
            return false;
        }
        if self.seen.contains(&identity) {
            return true;
        }
        if let Some(error) = self.too_many(chain) {
            let told = self.desk.sink.diagnostics.iter().any(|told| told.message == error.message);
            if !told {
                self.desk.sink.emit(error.at(place, "one parent too many"));
            }
            return false;
        }
        if let Some(known) = self.desk.library.members.get(&identity).cloned() {
            return known.is_some_and(|member| self.take_spec(&path, identity, member, place, chain));
        }
        match file::read(self.desk.files, &path) {
            Ok(text) => {
                let member = self.member(&path, identity.clone(), text);
                member.is_some_and(|member| self.take_spec(&path, identity, member, place, chain))
            }
            Err(error) => {
                let code = if error.code == "E0004" { "E0601" } else { error.code };
                let message = match error.message.strip_prefix("file not found: ") {
                    Some(shown) => format!("parent not found: {shown}"),
                    None => error.message.clone(),
                };
                let error = Diagnostic { code, message, ..error };
                self.desk.sink.emit(error.at(place, "named here, relative to this file"));
                false
            }
        }
    }

    /// E0109 if another parent would exceed the limit; reported once.
    fn too_many(&self, chain: &Chain) -> Option<Diagnostic> {
        let (message, help) = if chain.len() > MOST_GENERATIONS {
            let first = chain.first().map(|(_, shown)| shown.display().to_string()).unwrap_or_default();
            let message = format!("`{first}` extends a chain of more than {MOST_GENERATIONS} files");
            (message, "extend one of the first files of the chain, and write the values of the others there")
        } else if self.seen.len() > MOST_PARENTS {
            (format!("a spec has at most {MOST_PARENTS} parents"), "merge parents into one file")
        } else {
            return None;
        };
        Some(Diagnostic::error("E0109", message).help(help))
    }

    /// Removes the header's keys from a file. `None` if its edition is unknown.
    fn header(&mut self, body: &mut Map, source: SourceId) -> Option<Header> {
        let top = Span { source, start: 0, end: 0 };
        let Some(edition) = body.entries.remove(section::Header::spec.name) else {
            self.desk.sink.emit(without_edition(body, top));
            return None;
        };
        if !matches!(&edition.node.item,
            Item::Number(number) if number.whole == Some(i64::from(Edition::ONE.0)))
        {
            let message = format!("unsupported edition {}", edition.node.toml());
            let error =
                Diagnostic::error("E0003", message).at(edition.node.span, "specforge supports edition 1");
            self.desk.sink.emit(error.help("write `spec = 1`").fix(edition.node.span, "1"));
            return None;
        }
        let suite = body.entries.get("suite").map(|entry| entry.key);
        let key = if suite.is_some() { "suite" } else { section::Header::name.name };
        let name = self.take_text(body, key).filter(|(name, place)| self.check_name(name, *place));
        let summary = self
            .take_text(body, section::Header::summary.name)
            .map(|(summary, _)| summary)
            .unwrap_or_default();
        let is_abstract = suite.is_none() && self.take_flag(body, section::Header::r#abstract.name);
        let (extends, lost_parent) =
            self.take_extends(body.entries.remove(section::Header::extends.name).map(|entry| entry.node));
        let requires = match suite {
            None => self
                .take_requires(body.entries.remove(section::Header::requires.name).map(|entry| entry.node)),
            Some(_) => Vec::new(),
        };
        let name = name.map(|(name, _)| name);
        let place = Some(edition.key);
        Some(Header { place, name, suite, summary, is_abstract, extends, requires, lost_parent })
    }

    /// A name becomes a file name.
    fn check_name(&mut self, name: &str, place: Span) -> bool {
        let plain = is_file_name(name);
        if !plain {
            let error = Diagnostic::error("E0107", format!("invalid name `{name}`"));
            let error = error.at(place, "invalid name").help("use letters, digits, `_`, `-` and `.`");
            let safe = safe_name(name, |c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'));
            self.desk.sink.emit(match safe.as_deref().map(|safe| safe.trim_start_matches(['.', '_'])) {
                Some(safe) if !safe.is_empty() => error.fix(place, format!("\"{safe}\"")),
                _ => error,
            });
        }
        if name.len() > LONGEST_NAME {
            let error = Diagnostic::error(
                "E0107",
                format!("the name is too long for file names: {} bytes", name.len()),
            );
            let label = format!("at most {LONGEST_NAME} bytes");
            self.desk
                .sink
                .emit(error.at(place, label).help("shorten it, and describe the experiment in `summary`"));
        }
        plain && name.len() <= LONGEST_NAME
    }

    fn wrong(&mut self, key: &str, expected: &str, node: &Node) {
        let error =
            Diagnostic::error("E0103", format!("`{key}` takes {expected}, found {}", node.describe()));
        self.desk.sink.emit(error.at(node.span, "wrong type"));
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

    fn take_extends(&mut self, node: Option<Node>) -> (Vec<(String, Span)>, bool) {
        let (parents, wrong) = extends(node);
        wrong.iter().for_each(|item| self.wrong("extends", "a path or a list of paths", item));
        (parents, !wrong.is_empty())
    }

    fn take_requires(&mut self, node: Option<Node>) -> Vec<Required> {
        let (required, wrong) = requires::requires(node);
        wrong.iter().for_each(|item| self.wrong("requires", "a list of keys' paths", item));
        required
    }
}

/// E0002, for a spec or for another sort of file: `links` indicates a robot, a top-level `kind` a motion.
fn without_edition(body: &Map, top: Span) -> Diagnostic {
    let (message, label, help) = if body.get("links").is_some() {
        let help = "`specforge robot show NAME` checks and prints it; use it in a spec as `robot.model`";
        ("this file describes a robot, not a spec", "has `links` and no edition", help)
    } else if body.get("kind").is_some() {
        let help = "use it in a spec as `task.motion`; checking the spec checks the motion, too";
        ("this file describes a motion, not a spec", "has a `kind` and no edition", help)
    } else {
        let error = Diagnostic::error("E0002", "missing edition").at(top, "expected `spec = 1`");
        return error.help("add a first line `spec = 1`").fix(top, "spec = 1\n");
    };
    Diagnostic::error("E0002", message).at(top, label).help(help)
}

/// The parents named by a value of `extends`, and its invalid items.
pub fn extends(node: Option<Node>) -> (Vec<(String, Span)>, Vec<Node>) {
    let items = match node {
        None => Vec::new(),
        Some(Node { item: Item::List(items), .. }) => items,
        Some(node) => vec![node],
    };
    let (texts, wrong): (Vec<Node>, Vec<Node>) = items.into_iter().partition(|item| item.text().is_some());
    (texts.into_iter().filter_map(|item| Some((item.text()?.to_owned(), item.span))).collect(), wrong)
}

/// A path in a file, relative to that file; `..` is resolved where possible.
pub fn beside(file: &Path, name: &str) -> PathBuf {
    files::plain(&file.parent().unwrap_or(Path::new("")).join(name))
}
