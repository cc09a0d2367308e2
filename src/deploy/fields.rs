//! Checks decoded fields that were read from a file against this version's descriptors: every key must be
//! present, with a value of its type within its bounds, and no others.
//!
//! A spec is decoded by this version; a policy's fields were decoded when it was exported, possibly by
//! another version of specforge with other keys.

use crate::kinds::vocabulary::vocabulary;
use crate::spec::value::KIND;
use crate::spec::{Kind, Param, Presence, Section, Shape, Table, Ty, Value, bounds};

/// The sections of an environment.
const SECTIONS: [&str; 9] =
    ["physics", "terrain", "task", "initial", "observe", "reward", "terminate", "randomize", "action"];

/// The first place in which the fields of an environment do not match this version; `None` if they all match.
pub fn misfit(fields: &Table) -> Option<String> {
    let vocabulary = vocabulary();
    let mut sections =
        SECTIONS.into_iter().filter_map(|name| vocabulary.section(name).map(|section| (name, section)));
    sections.find_map(|(name, section)| match (fields.get(name), &section.shape) {
        (None, _) => section.required.then(|| format!("`{name}` is missing")),
        (Some(Value::Table(table)), Shape::Plain(params)) => keys(table, &[params], name, &[]),
        (Some(Value::Table(table)), Shape::Kind(kinds)) => of_kind(table, kinds, &[], name, None),
        (Some(Value::Table(table)), Shape::Terms(kinds, extra)) => terms(table, kinds, extra, name),
        _ => Some(format!("`{name}` is not a table")),
    })
}

/// Named terms.
fn terms(table: &Table, kinds: &[&'static Kind], extra: &'static [Param], path: &str) -> Option<String> {
    table.iter().find_map(|(term, value)| {
        let path = format!("{path}.{term}");
        match value {
            Value::Table(table) => of_kind(table, kinds, extra, &path, Some(term)),
            _ => Some(format!("`{path}` is not a table")),
        }
    })
}

/// A table of a kind; without the key `kind`, its name is the kind.
fn of_kind(
    table: &Table,
    kinds: &[&'static Kind],
    extra: &'static [Param],
    path: &str,
    name: Option<&str>,
) -> Option<String> {
    let Some(word) = Section::new(table).kind().or(name) else {
        return Some(format!("`{path}` has no kind"));
    };
    match kinds.iter().find(|kind| kind.name == word) {
        Some(kind) => keys(table, &[kind.params, extra], path, &[KIND]),
        None => Some(format!("`{path}` has the unknown kind `{word}`")),
    }
}

fn keys(table: &Table, params: &[&'static [Param]], path: &str, reserved: &[&str]) -> Option<String> {
    let known = || params.iter().copied().flatten();
    let foreign = table
        .keys()
        .find(|key| !reserved.contains(&key.as_str()) && known().all(|param| param.name != **key));
    if let Some(key) = foreign {
        return Some(format!("`{path}.{key}` is unknown"));
    }
    known().find_map(|param| match (table.get(param.name), param.presence) {
        (None, Presence::Optional) => None,
        (None, _) => Some(format!("`{path}.{}` is missing", param.name)),
        (Some(value), _) => of_key(param, value, &format!("{path}.{}", param.name)),
    })
}

/// What is wrong with the value of a key: a wrong type, or a number out of bounds.
fn of_key(param: &Param, value: &Value, path: &str) -> Option<String> {
    let violation = || bounds::violation(param, value).map(|what| format!("`{path}` {what}"));
    of_type(&param.ty, value, path).or_else(violation)
}

/// Why a value does not have the decoded form of a type; `None` if it has.
fn of_type(ty: &Ty, value: &Value, path: &str) -> Option<String> {
    match (ty, value) {
        (Ty::Flag, Value::Flag(_)) | (Ty::Count, Value::Count(_)) | (Ty::Text, Value::Text(_)) => None,
        (Ty::Number | Ty::Quantity(_) | Ty::Ratio(_), Value::Quantity(quantity))
            if quantity.si.is_finite() =>
        {
            None
        }
        (Ty::Sampler(_), Value::Quantity(_) | Value::Sampler(_)) => None,
        (Ty::Choice(words), Value::Text(text)) if words.contains(&text.as_str()) => None,
        (Ty::List(item), Value::List(items)) => items.iter().find_map(|value| of_type(item, value, path)),
        (Ty::Table(params), Value::Table(table)) => keys(table, &[params], path, &[]),
        (Ty::Named(item), Value::Table(table)) => table.values().find_map(|value| of_type(item, value, path)),
        (Ty::Kind(kinds), Value::Table(table)) => of_kind(table, &(kinds.all)(), &[], path, None),
        (Ty::Terms(kinds), Value::Table(table)) => terms(table, &(kinds.all)(), &[], path),
        (Ty::OneOf(types), _) => {
            let mut flaws: Vec<String> = Vec::new();
            for ty in *types {
                flaws.push(of_type(ty, value, path)?);
            }
            let foreign = foreign(path);
            Some(flaws.into_iter().find(|flaw| *flaw != foreign).unwrap_or(foreign))
        }
        _ => Some(foreign(path)),
    }
}

fn foreign(path: &str) -> String {
    format!("`{path}` has the wrong type")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::checked;
    use crate::spec::{LoadOptions, Quantity};

    fn fields(spec: &str, profile: Option<&str>) -> Table {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs").join(spec);
        let options = LoadOptions { profile: profile.map(str::to_owned), ..LoadOptions::default() };
        checked(&path, &options).experiment.expect("it is sound").table
    }

    #[test]
    fn the_fields_of_every_shipped_spec_in_every_profile_are_those_of_this_edition() {
        let folder =
            std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("specs")).expect("the folder");
        let names = folder.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
        let specs: Vec<String> = names.filter(|name| name.ends_with(".toml")).collect();
        assert!(specs.len() >= 10);
        for spec in specs {
            for profile in [None, Some("quick"), Some("desk")] {
                assert_eq!(misfit(&fields(&spec, profile)), None, "{spec} {profile:?}");
            }
        }
    }

    #[test]
    fn a_key_too_few_one_too_many_another_type_and_another_kind_are_named() {
        let good = fields("tocabi_walk_torque.toml", None);
        let changed = |section: &str, change: fn(&mut Table)| {
            let mut fields = good.clone();
            if let Some(Value::Table(table)) = fields.get_mut(section) {
                change(table);
            }
            misfit(&fields).unwrap_or_default()
        };
        assert_eq!(changed("action", |table| drop(table.remove("delay"))), "`action.delay` is missing");
        assert_eq!(
            changed("action", |table| drop(table.insert("new".into(), Value::Flag(true)))),
            "`action.new` is unknown"
        );
        assert_eq!(
            changed("task", |table| drop(table.insert("episode".into(), Value::Flag(true)))),
            "`task.episode` has the wrong type"
        );
        let infinite = |table: &mut Table| {
            table.insert("rate".into(), Value::Quantity(Quantity { si: f64::NAN, text: String::new() }));
        };
        assert_eq!(changed("physics", infinite), "`physics.rate` has the wrong type");
        assert_eq!(
            changed("reward", |table| drop(table.insert("smile".into(), Value::Table(Table::new())))),
            "`reward.smile` has the unknown kind `smile`"
        );
        let number = |key: &'static str, si: f64| {
            move |table: &mut Table| {
                drop(table.insert(key.into(), Value::Quantity(Quantity { si, text: String::new() })))
            }
        };
        let bounded = |section: &str, key: &'static str, si: f64| {
            let mut fields = good.clone();
            if let Some(Value::Table(table)) = fields.get_mut(section) {
                number(key, si)(table);
            }
            misfit(&fields).unwrap_or_default()
        };
        assert_eq!(
            bounded("terrain", "friction", -1.0),
            "`terrain.friction` is -1, not between 0 and 10 in SI units"
        );
        for (section, key, si) in
            [("task", "episode", 0.0), ("task", "episode", 1e300), ("action", "std", 1e9)]
        {
            let said = bounded(section, key, si);
            assert!(
                said.starts_with(&format!("`{section}.{key}` is ")) && said.contains("not between"),
                "{said}"
            );
        }
        let every = |table: &mut Table| {
            let Some(Value::Table(command)) = table.get_mut("command") else {
                unreachable!("a walk has a command")
            };
            command.insert("every".into(), Value::Quantity(Quantity { si: 1e-320, text: String::new() }));
        };
        assert!(changed("task", every).starts_with("`task.command.every` is "), "{}", changed("task", every));
        let mut none = good.clone();
        none.remove("terrain");
        assert_eq!(misfit(&none).as_deref(), Some("`terrain` is missing"));
    }
}
