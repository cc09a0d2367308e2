//! Splits a suite's file into what concerns the suite itself and what is assigned to all arms.

use std::sync::Arc;

use super::axis::RESERVED;
use super::{ClaimPolicy, wrong_type};
use crate::diag::{Diagnostic, Sink};
use crate::spec::family::Member;
use crate::spec::section::Header;
use crate::spec::suggest::{listed, nearest};
use crate::spec::{LoadOptions, Vocabulary};
use crate::syntax::{Entry, Item, Layer, Map, Node};

/// Keys of a suite that specs do not have, in addition to `suite` itself.
const OWN: &[&str] = &["sweep", "claim", "claims"];

/// The parts of a suite's file.
pub struct Parts {
    /// The file as the last parent of every arm: sections, profiles and allowed warnings.
    pub member: Arc<Member>,
    /// `[sweep]`
    pub sweep: Option<Entry>,
    /// `sweep.seeds` of the chosen profile.
    pub profile_seeds: Option<Node>,
    /// The tables `[[claim]]`.
    pub claims: Vec<Node>,
    /// `claims`, of the chosen profile or of the suite.
    pub policy: ClaimPolicy,
    /// `[report]`
    pub report: Option<Entry>,
}

/// Splits a suite.
pub fn split(file: &Member, options: &LoadOptions, vocabulary: &Vocabulary, sink: &mut Sink) -> Parts {
    let mut body = file.body.clone();
    let sweep = body.entries.remove("sweep");
    let claims = body.entries.remove("claim").map(|entry| claims(entry.node, sink)).unwrap_or_default();
    let own = body.entries.remove("claims").and_then(|entry| policy(&entry.node, sink));
    let report = body.entries.remove("report");
    unknown_keys(&mut body, vocabulary, sink);
    let chosen = options.profile.as_deref();
    let (profile_seeds, of_profile) = profiles(&mut body, chosen, sink);
    let member = Arc::new(Member { source: file.source, header: file.header.clone(), body });
    Parts { member, sweep, profile_seeds, claims, policy: of_profile.or(own).unwrap_or_default(), report }
}

fn claims(node: Node, sink: &mut Sink) -> Vec<Node> {
    match node.item {
        Item::List(items) => items,
        _ => {
            sink.emit(
                wrong_type("claim", "tables of its own", &node).help("write `[[claim]]` for each claim"),
            );
            Vec::new()
        }
    }
}

/// `claims = "count"` or `"report"`.
fn policy(node: &Node, sink: &mut Sink) -> Option<ClaimPolicy> {
    match node.text() {
        Some("count") => Some(ClaimPolicy::Count),
        Some("report") => Some(ClaimPolicy::Report),
        found => {
            let error = match found {
                Some(word) => {
                    let message = format!("`claims` takes `report` or `count`, found `{word}`");
                    let error = Diagnostic::error("E0106", message).at(node.span, "invalid choice");
                    match nearest(word, ["report", "count"]) {
                        Some(near) => error.fix(node.span, format!("\"{near}\"")),
                        None => error,
                    }
                }
                None => wrong_type("claims", "`\"report\"` or `\"count\"`", node),
            };
            sink.emit(error.help(
                "`\"count\"` makes a failed claim end the run with exit code 5; `\"report\"` only reports it",
            ));
            None
        }
    }
}

/// Removes `sweep` and `claims` from all profiles; returns those of the chosen one.
fn profiles(body: &mut Map, chosen: Option<&str>, sink: &mut Sink) -> (Option<Node>, Option<ClaimPolicy>) {
    let (mut seeds, mut of_profile) = (None, None);
    let profiles = body.entries.get_mut("profile").and_then(|entry| entry.node.table_mut());
    for (name, entry) in profiles.into_iter().flat_map(|map| map.entries.iter_mut()) {
        let Some(map) = entry.node.table_mut() else { continue };
        let sweep = map.entries.remove("sweep").and_then(|entry| only_seeds(name, entry, sink));
        let claims = map.entries.remove("claims").and_then(|entry| policy(&entry.node, sink));
        if let Some(entry) = map.entries.remove("report") {
            let error =
                Diagnostic::error("E0102", format!("`report` in the profile `{name}`")).at(entry.key, "");
            sink.emit(error.help("a suite has one report: write `[report]` at the top"));
        }
        if chosen == Some(name) {
            (seeds, of_profile) = (sweep, claims);
        }
    }
    (seeds, of_profile)
}

/// Only `seeds` is allowed in `sweep` of a profile: the arms are the same under every profile.
fn only_seeds(profile: &str, entry: Entry, sink: &mut Sink) -> Option<Node> {
    let Item::Table(mut map) = entry.node.item else {
        sink.emit(wrong_type("sweep", "a table", &entry.node));
        return None;
    };
    let seeds = map.entries.remove("seeds").map(|entry| entry.node);
    for (key, entry) in &map.entries {
        let error = Diagnostic::error("E0102", format!("unknown key `{key}` in `profile.{profile}.sweep`"));
        sink.emit(
            error.at(entry.key, "").help("a profile changes only `sweep.seeds`: the arms stay the same"),
        );
    }
    seeds.map(|mut node| {
        node.stamp(Layer::Profile);
        node
    })
}

/// Reports keys unknown to suites and specs, and drops them so that arms do not report them again.
fn unknown_keys(body: &mut Map, vocabulary: &Vocabulary, sink: &mut Sink) {
    let header = Header::names().filter(|key| !Header::OF_SPECS.contains(key));
    let sections = vocabulary.sections.iter().map(|section| section.name);
    let names: Vec<&str> = sections.chain(header).chain(OWN.iter().copied()).chain(["suite"]).collect();
    body.entries.retain(|key, entry| {
        if names.contains(&key.as_str()) {
            return true;
        }
        if sink.is_full("E0102") {
            return false;
        }
        let error = Diagnostic::error("E0102", format!("unknown key `{key}` in a suite")).at(entry.key, "");
        sink.emit(match nearest(key, names.iter().copied()) {
            _ if key == Header::name.name => {
                error.help("it belongs to a spec; a suite has its name in `suite`")
            }
            _ if Header::OF_SPECS.contains(&key.as_str()) => error.help("it belongs to a parent of specs"),
            _ if RESERVED.contains(&key.as_str()) => {
                error.help(format!("write it in `[sweep]`: `sweep.{key}`"))
            }
            Some(near) => error.help(format!("did you mean `{near}`?")).fix(entry.key, near),
            None => error.help(format!(
                "apart from sections, a suite has the keys \
                 {}",
                listed(OWN.iter().copied())
            )),
        });
        false
    });
}
