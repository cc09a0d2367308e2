//! The profiles of a spec: overlays chosen on the command line, which may extend one another.

use std::collections::BTreeMap;
use std::path::Path;

use super::section::Header;
use super::suggest::{is_file_name, listed, nearest};
use crate::diag::{Diagnostic, Sink, Span};
use crate::escape;
use crate::syntax::{Entry, Item, Layer, Map, Node};

/// Maximum number of profiles of a spec.
const MOST: usize = 2000;
/// Maximum length of a chain of profiles that extend one another.
const MOST_GENERATIONS: usize = 8;
/// Maximum length of a profile's name in bytes.
const LONGEST_PROFILE: usize = 64;
/// The key with the name of the profile that a profile extends.
const EXTENDS: &str = "extends";

/// The profiles of a merged spec.
#[derive(Clone, Debug, Default)]
pub struct Profiles {
    own: BTreeMap<String, Map>,
    /// What each profile that extends another one extends; without cycles and unknown names.
    extends: BTreeMap<String, String>,
}

/// What a profile extends, as written.
struct Extends {
    profile: String,
    named: String,
    place: Span,
}

impl Profiles {
    /// Removes the profiles from a merged spec. Reports profiles that are not tables, that extend an unknown
    /// profile, and those beyond the limit.
    pub fn take(root: &mut Map, sink: &mut Sink) -> Self {
        let Some(entry) = root.entries.remove(Header::profile.name) else { return Self::default() };
        let Item::Table(map) = entry.node.item else {
            sink.emit(not_a_table(&entry.node, "`profile`"));
            return Self::default();
        };
        let mut entries = map.entries;
        drop_surplus(&mut entries, sink);
        let mut profiles = Self::default();
        let mut written = Vec::new();
        for (name, mut entry) in entries {
            if let Some(error) = misnamed(&name, &entry) {
                sink.emit(error);
                continue;
            }
            entry.node.stamp(Layer::Profile);
            let described = entry.node.describe();
            let Item::Table(mut map) = entry.node.item else {
                let message = format!("`profile.{name}` must be a table, found {described}");
                sink.emit(Diagnostic::error("E0103", message).at(entry.node.span, "not a table"));
                continue;
            };
            let extended = map.entries.remove(EXTENDS);
            written.extend(extended.and_then(|entry| extends(&name, &entry.node, sink)));
            profiles.own.insert(name, map);
        }
        written.into_iter().for_each(|extends| profiles.link(extends, sink));
        profiles
    }

    /// Their names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.own.keys().map(String::as_str)
    }

    /// A profile and those that it extends, lowest priority first; empty if it is unknown.
    pub fn chain(&self, name: &str) -> Vec<&Map> {
        self.lineage(name).into_iter().filter_map(|name| self.own.get(name)).collect()
    }

    /// The names of a profile and of those that it extends, lowest priority first.
    pub fn lineage<'a>(&'a self, name: &'a str) -> Vec<&'a str> {
        let links = std::iter::successors(Some(name), |name| self.extends.get(*name).map(String::as_str));
        let mut lineage: Vec<&str> = links.collect();
        lineage.reverse();
        lineage
    }

    /// The name of the profile that has a value at a place.
    pub fn holder(&self, place: Span) -> Option<&str> {
        self.own.iter().find(|(_, map)| holds(map, place)).map(|(name, _)| name.as_str())
    }

    /// Records what a profile extends, unless it does not exist or the chain would be a cycle or too long.
    fn link(&mut self, extends: Extends, sink: &mut Sink) {
        let Extends { profile, named, place } = extends;
        if !self.own.contains_key(&named) {
            let message = format!("the profile `{profile}` extends an unknown profile `{named}`");
            let error = Diagnostic::error("E0706", message).at(place, "");
            let others = || self.names().filter(|name| *name != profile);
            sink.emit(match nearest(&named, others()) {
                Some(near) => error.help(format!("did you mean `{near}`?")).fix(place, format!("\"{near}\"")),
                None if others().next().is_none() => error.help("this spec has no other profile"),
                None => error.help(format!("the other profiles of this spec are {}", listed(others()))),
            });
            return;
        }
        let cycle = named == profile || self.extended(&named).any(|below| below == profile);
        let generations = 2 + self.extended(&named).count() + self.longest_above(&profile);
        if cycle {
            let error = Diagnostic::error("E0602", format!("the profile `{profile}` extends itself"));
            sink.emit(error.at(place, "closes the cycle").help("remove one of these `extends`"));
        } else if generations > MOST_GENERATIONS {
            let message = format!("a chain of more than {MOST_GENERATIONS} profiles");
            let error = Diagnostic::error("E0109", message).at(place, "one profile too many");
            sink.emit(error.help("extend one of the first profiles of the chain"));
        } else {
            self.extends.insert(profile, named);
        }
    }

    /// The profiles that a profile extends, directly and indirectly.
    fn extended<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        std::iter::successors(self.extends.get(name), |name| self.extends.get(*name)).map(String::as_str)
    }

    /// The length of the longest chain of profiles that extend a profile, without it.
    fn longest_above(&self, name: &str) -> usize {
        let distance = |child: &str| self.extended(child).position(|below| below == name).map(|at| at + 1);
        self.extends.keys().filter_map(|child| distance(child)).max().unwrap_or(0)
    }
}

/// E0107 for a profile whose name cannot be part of a file name.
fn misnamed(name: &str, entry: &Entry) -> Option<Diagnostic> {
    let is_plain = is_file_name(name);
    if is_plain && name.len() <= LONGEST_PROFILE {
        return None;
    }
    if is_plain {
        let message = format!("the name of this profile is too long: {} bytes", name.len());
        let error =
            Diagnostic::error("E0107", message).at(entry.key, format!("at most {LONGEST_PROFILE} bytes"));
        return Some(error.help("shorten it: it becomes part of file names"));
    }
    let error =
        Diagnostic::error("E0107", format!("invalid name of a profile: `{}`", escape::file(Path::new(name))));
    Some(error.at(entry.key, "invalid name").help("use letters, digits, `_`, `-` and `.`"))
}

/// Whether a table has a value at a place.
fn holds(map: &Map, place: Span) -> bool {
    map.entries
        .values()
        .any(|entry| entry.node.span == place || entry.node.table().is_some_and(|table| holds(table, place)))
}

fn not_a_table(node: &Node, what: &str) -> Diagnostic {
    let message = format!("{what} must be a table, found {}", node.describe());
    Diagnostic::error("E0103", message).at(node.span, "not a table")
}

/// Reports and drops the last profiles of a file with too many.
fn drop_surplus(entries: &mut BTreeMap<String, Entry>, sink: &mut Sink) {
    let mut places: Vec<(Span, String)> =
        entries.iter().map(|(name, entry)| (entry.key, name.clone())).collect();
    places.sort_by_key(|(place, _)| (place.source, place.start));
    let Some((first, _)) = places.get(MOST) else { return };
    let error = Diagnostic::error("E0009", format!("more than {MOST} profiles"));
    sink.emit(error.at(*first, "one too many").help("use the sweep of a suite for many variants"));
    places[MOST..].iter().for_each(|(_, name)| drop(entries.remove(name)));
}

/// The value of `extends` in a profile.
fn extends(profile: &str, node: &Node, sink: &mut Sink) -> Option<Extends> {
    if let Some(named) = node.text() {
        return Some(Extends { profile: profile.to_owned(), named: named.to_owned(), place: node.span });
    }
    let message =
        format!("`profile.{profile}.{EXTENDS}` takes the name of a profile, found {}", node.describe());
    let error = Diagnostic::error("E0103", message).at(node.span, "wrong type");
    sink.emit(error.help("a profile extends one other profile: `extends = \"desk\"`"));
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Sources;
    use crate::syntax::parse;

    fn read(text: &str) -> (Profiles, Vec<(&'static str, String)>) {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let source = sources.add("a.toml", text);
        let node = parse(&sources, source, &mut sink).expect("valid TOML");
        let mut root = node.table().expect("a table").clone();
        let profiles = Profiles::take(&mut root, &mut sink);
        assert!(root.entries.is_empty());
        (profiles, sink.diagnostics.into_iter().map(|found| (found.code, found.message)).collect())
    }

    fn keys(profiles: &Profiles, name: &str) -> Vec<Vec<String>> {
        profiles.chain(name).into_iter().map(|map| map.entries.keys().cloned().collect()).collect()
    }

    #[test]
    fn a_profile_comes_after_those_that_it_extends() {
        let (profiles, found) = read(
            "[profile.c]\nextends = \"b\"\nz = 1\n[profile.b]\nextends = \"a\"\ny = 1\n[profile.a]\nx = 1\n",
        );
        assert_eq!(found, []);
        assert_eq!(keys(&profiles, "c"), [["x"], ["y"], ["z"]]);
        assert_eq!(keys(&profiles, "a"), [["x"]]);
        assert!(profiles.chain("d").is_empty());
    }

    #[test]
    fn unknown_profiles_cycles_and_long_chains_are_reported_and_left_out() {
        let (profiles, found) = read("[profile.quick]\nextends = \"desks\"\nx = 1\n[profile.desk]\ny = 1\n");
        let unknown = "the profile `quick` extends an unknown profile `desks`";
        assert_eq!(found, [("E0706", unknown.to_owned())]);
        assert_eq!(keys(&profiles, "quick"), [["x"]]);
        let (profiles, found) = read("[profile.a]\nextends = \"b\"\n[profile.b]\nextends = \"a\"\n");
        assert_eq!(found, [("E0602", "the profile `b` extends itself".to_owned())]);
        assert_eq!(profiles.chain("a").len(), 2);
        let (_, found) = read("[profile.a]\nextends = \"a\"\n");
        assert_eq!(found, [("E0602", "the profile `a` extends itself".to_owned())]);
        let (_, found) = read("[profile.a]\nextends = [\"b\"]\n[profile]\nb = 1\n");
        assert_eq!(found.iter().map(|(code, _)| *code).collect::<Vec<_>>(), ["E0103", "E0103"]);
        for order in [(0..20).collect::<Vec<_>>(), (0..20).rev().collect()] {
            let chain = order.into_iter().map(|at| match at {
                0 => "[profile.p0]\nx = 1\n".to_owned(),
                _ => format!("[profile.p{at}]\nextends = \"p{}\"\n", at - 1),
            });
            let (profiles, found) = read(&chain.collect::<String>());
            assert!(found.iter().all(|(code, _)| *code == "E0109") && !found.is_empty(), "{found:?}");
            let longest = profiles.names().map(|name| profiles.chain(name).len()).max();
            assert_eq!(longest, Some(MOST_GENERATIONS));
        }
    }
}
