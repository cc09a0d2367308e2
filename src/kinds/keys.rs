//! All keys of the language by their paths, from the descriptors: the content of `explain learn.samples` and
//! `list keys`.

use std::fmt::Write;

use super::vocabulary::vocabulary;
use super::{motion, reference};
use crate::quantity::Dimension;
use crate::robot::file;
use crate::spec::marks::below;
use crate::spec::section::Header;
use crate::spec::typed::Keys as _;
use crate::spec::value;
use crate::spec::{Kind, Param, Presence, Shape, Ty};

/// The keys `kind` and `enabled`, of every table that has them.
const KIND: Param = Param::optional(value::KIND, Ty::Text).doc("The table's kind, from the registry.");
const ENABLED: Param = Param::default("enabled", Ty::Flag, "true")
    .doc("`false` switches the table off, for example one that a parent sets.");

/// A key at one path.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its path: `learn.samples`, `reward.torque.k` for the terms of a kind, `robots.links.mass` for robot
    /// files.
    pub path: String,
    /// The kinds that have it in this form; empty if tables have no kind.
    pub kinds: Vec<&'static str>,
    /// Its descriptor.
    pub param: &'static Param,
}

impl Key {
    /// The last step of the path.
    pub fn name(&self) -> &'static str {
        self.param.name
    }

    /// Its value if it is missing.
    pub fn absent(&self) -> String {
        match self.param.presence {
            Presence::Required => "required".to_owned(),
            Presence::Optional => "optional".to_owned(),
            Presence::Default(value) => format!("default {value}"),
        }
    }

    /// Description of its type.
    pub fn takes(&self) -> String {
        reference::takes(self.param)
    }

    /// Description of its bounds.
    pub fn range(&self) -> String {
        self.param.range.map(|(low, high)| format!("from {low} to {high} in SI units")).unwrap_or_default()
    }

    /// Its page.
    pub fn page(&self) -> String {
        let mut text = format!("# {}\n\n{}\n\n", self.path, self.param.doc);
        let _ = writeln!(text, "* takes {}", self.takes());
        let _ = writeln!(text, "* {}", self.absent().replacen("default ", "when absent: ", 1));
        if !self.range().is_empty() {
            let _ = writeln!(text, "* {}", self.range());
        }
        if !self.kinds.is_empty() {
            let kinds: Vec<String> = self.kinds.iter().map(|kind| format!("`{kind}`")).collect();
            let _ = writeln!(text, "* of kind {}", kinds.join(", "));
        }
        text
    }

    /// Whether a word refers to it: its path, its path without the kind of a named term, or its last steps.
    pub fn is_called(&self, word: &str) -> bool {
        self.path == word
            || self.path.ends_with(&format!(".{word}"))
            || self.without_term() == Some(word.to_owned())
    }

    /// `reward.torque.k` as `reward.k`.
    fn without_term(&self) -> Option<String> {
        let (section, rest) = self.path.split_once('.')?;
        let (_, key) = rest.split_once('.')?;
        Some(format!("{section}.{key}"))
    }

    /// Whether its value can have a dimension.
    pub fn has_dimension(&self, dimension: Dimension) -> bool {
        measures(&self.param.ty, dimension)
    }
}

/// Whether a type contains quantities of a dimension, outside tables with their own keys.
fn measures(ty: &Ty, dimension: Dimension) -> bool {
    match ty {
        Ty::Quantity(own) | Ty::Sampler(own) => *own == dimension,
        Ty::Ratio(_) => dimension == Dimension::NONE,
        Ty::List(item) | Ty::Named(item) => measures(item, dimension),
        Ty::OneOf(types) => types.iter().any(|ty| measures(ty, dimension)),
        Ty::Flag | Ty::Count | Ty::Number | Ty::Text | Ty::Choice(_) => false,
        Ty::Table(_) | Ty::Kind(_) | Ty::Terms(_) => false,
    }
}

/// All keys: those of specs in the order of a spec, then those of motion files and of robot files.
pub fn keys() -> Vec<Key> {
    let mut keys = Vec::new();
    collect(Header::PARAMS, "", &[], &mut keys);
    for section in vocabulary().sections {
        match &section.shape {
            Shape::Plain(params) => collect(params, section.name, &[], &mut keys),
            Shape::Kind(kinds) => {
                add(&KIND, section.name, &[], &mut keys);
                if !section.required {
                    add(&ENABLED, section.name, &[], &mut keys);
                }
                kinds.iter().for_each(|kind| collect(kind.params, section.name, &[kind.name], &mut keys));
            }
            Shape::Terms(kinds, extra) => {
                add(&KIND, section.name, &[], &mut keys);
                add(&ENABLED, section.name, &[], &mut keys);
                collect(extra, section.name, &[], &mut keys);
                of_terms(section.name, kinds, &mut keys);
            }
        }
    }
    of_terms("motion", &motion::kinds(), &mut keys);
    collect(file::PARAMS, "robots", &[], &mut keys);
    keys
}

fn of_terms(section: &str, kinds: &[&'static Kind], keys: &mut Vec<Key>) {
    for kind in kinds {
        collect(kind.params, &format!("{section}.{}", kind.name), &[kind.name], keys);
    }
}

/// Adds keys and those of nested tables.
fn collect(params: &'static [Param], path: &str, kinds: &[&'static str], keys: &mut Vec<Key>) {
    for param in params {
        add(param, path, kinds, keys);
        for table in reference::tables(&param.ty) {
            collect(table, &below(path, param.name), kinds, keys);
        }
    }
}

/// Adds a key; kinds with the same key share an entry.
fn add(param: &'static Param, path: &str, kinds: &[&'static str], keys: &mut Vec<Key>) {
    let path = below(path, param.name);
    let same = |key: &&mut Key| key.path == path && format!("{:?}", key.param) == format!("{param:?}");
    match keys.iter_mut().find(same) {
        Some(key) => key.kinds.extend(kinds),
        None => keys.push(Key { path, kinds: kinds.to_vec(), param }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(word: &str) -> Vec<String> {
        keys().into_iter().filter(|key| key.is_called(word)).map(|key| key.path).collect()
    }

    #[test]
    fn keys_are_found_by_path_by_section_and_by_name() {
        assert_eq!(found("learn.samples"), ["learn.samples"]);
        assert!(found("samples").contains(&"pretrain.samples".to_owned()));
        assert_eq!(found("reward.k").len(), 10, "each reward term with a kernel has one");
        assert_eq!(found("task.command.ramp"), ["task.command.ramp"]);
        assert_eq!(found("links.mass"), ["robots.links.mass"]);
        assert_eq!(found("learn.nothing"), [""; 0]);
    }

    #[test]
    fn a_key_of_two_kinds_is_one_entry_where_it_means_the_same() {
        let of = |path: &str| {
            keys().into_iter().filter(|key| key.path == path).map(|key| key.kinds).collect::<Vec<_>>()
        };
        assert_eq!(of("action.rate"), [["position", "torque"]]);
        assert_eq!(of("action.std"), [["position"], ["torque"]], "they are shares of different things");
    }

    #[test]
    fn keys_know_their_dimension() {
        let rates: Vec<String> =
            keys().into_iter().filter(|key| key.has_dimension(Dimension::RATE)).map(|key| key.path).collect();
        assert!(
            rates.contains(&"physics.rate".to_owned()) && rates.contains(&"action.servo_rate".to_owned())
        );
        assert!(!rates.contains(&"learn.samples".to_owned()));
    }
}
