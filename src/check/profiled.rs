//! W0525: values of a spec that a profile of one of its parents overrides.

use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::escape;
use crate::spec::Experiment;
use crate::spec::family::{Family, Member};
use crate::spec::marks::below;
use crate::syntax::{Layer, Map, Node};

/// An inherited profile replaces no value that the spec itself writes, unless the spec's own table of that
/// profile says so. A parent's value that its own profile replaces is intended.
pub fn own_values_last(experiment: &Experiment, family: &Family, sources: &Sources, sink: &mut Sink) {
    let Some(profile) = experiment.profile.as_deref().filter(|_| !experiment.is_abstract) else { return };
    let Some((own, parents)) = family.members.split_last() else { return };
    if own.source != experiment.source {
        return;
    }
    let of_profile =
        |profile| parents.iter().filter_map(move |parent| Some((parent.source, overlay(parent, profile)?)));
    let tables: Vec<(SourceId, &Map)> = experiment.lineage().into_iter().flat_map(of_profile).collect();
    let search = Search { experiment, profile, tables, own: &own.body, sources };
    // What the spec writes for a profile that the chosen one extends can be lost, too.
    let extended = experiment.lineage().into_iter().filter(|name| *name != profile);
    let own_tables = extended.filter_map(|name| overlay(own, name)).flat_map(|map| &map.entries);
    let sections = own.body.entries.iter().filter(|(key, _)| *key != "profile");
    for (key, entry) in sections.chain(own_tables) {
        search.look(key, &entry.node, sink);
    }
}

/// A file's own table of a profile.
fn overlay<'a>(member: &'a Member, profile: &str) -> Option<&'a Map> {
    member.body.get("profile")?.table()?.get(profile)?.table()
}

struct Search<'a> {
    experiment: &'a Experiment,
    profile: &'a str,
    /// The tables of the profile and of those that it extends, lowest priority first.
    tables: Vec<(SourceId, &'a Map)>,
    /// The spec's own sections.
    own: &'a Map,
    sources: &'a Sources,
}

impl Search<'_> {
    fn look(&self, path: &str, written: &Node, sink: &mut Sink) {
        let experiment = self.experiment;
        match experiment.marks.get(path).filter(|mark| !mark.text.is_empty()) {
            Some(mark) if mark.layer == Layer::Profile && mark.value.source != experiment.source => {
                if mark.text != written.toml() {
                    self.tell(path, written, mark.value, &mark.text, sink);
                }
            }
            Some(_) => {}
            None => match written.table() {
                Some(map) if !map.entries.is_empty() => {
                    map.entries
                        .iter()
                        .for_each(|(key, entry)| self.look(&below(path, key), &entry.node, sink));
                }
                _ => self.dropped(path, written, sink),
            },
        }
    }

    /// A value whose table a profile disables or gives another kind.
    fn dropped(&self, path: &str, written: &Node, sink: &mut Sink) {
        let tables = path.match_indices('.').map(|(end, _)| &path[..end]);
        for table in tables {
            let off = |map: &Map| {
                let off = map.at(table)?.table()?.get("enabled").filter(|node| node.toml() == "false")?;
                Some((off.span, format!("{table}.enabled = false")))
            };
            // The spec disables the term itself.
            if off(self.own).is_some() {
                return;
            }
            let switched = |(_, map): &(SourceId, &Map)| off(map);
            if let Some((place, words)) = self.tables.iter().rev().find_map(switched) {
                let agrees = words == format!("{path} = {}", written.toml());
                if self.is_off(table) && !agrees {
                    self.tell(path, written, place, &words, sink);
                }
                return;
            }
        }
    }

    /// Whether a term is absent from the decoded spec.
    fn is_off(&self, table: &str) -> bool {
        let mut keys = table.split('.');
        let section = keys.next().and_then(|name| self.experiment.section(name));
        section.and_then(|section| keys.try_fold(section, |section, key| section.section(key))).is_none()
    }

    fn tell(&self, path: &str, written: &Node, place: Span, value: &str, sink: &mut Sink) {
        let (profile, own) = (self.profile, written.toml());
        let holder = self.experiment.profile_of(place);
        let parent = escape::file(&self.sources.get(place.source).name);
        let message = format!(
            "`{path} = {own}` of this spec has no effect with `--profile {profile}`: {parent} overrides it"
        );
        let [keep, confirm] = match value.strip_suffix(".enabled = false") {
            Some(table) => [format!("{table}.enabled = true"), format!("{table}.enabled = false")],
            None => [format!("{path} = {own}"), format!("{path} = {value}")],
        };
        let help = format!(
            "write `profile.{holder}.{keep}` in this spec to keep the value, or \
             `profile.{holder}.{confirm}` if the profile is right"
        );
        let diagnostic = Diagnostic::warning("W0525", message).at(written.span, "overridden by the profile");
        sink.emit(diagnostic.note(place, format!("the value of profile `{holder}`")).help(help));
    }
}
