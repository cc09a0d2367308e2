//! Normalizes recipes by removing every key that has its default, at any depth. Therefore a key that is added
//! later, with a default that gives the old behaviour, invalidates no stage.

use std::sync::OnceLock;

use serde_json::{Map, Value as Json};

use super::fingerprint::canonical_json;
use crate::kinds::motion;
use crate::kinds::vocabulary::vocabulary;
use crate::spec::decode::default_value;
use crate::spec::{Kind, Param, Presence, Shape, Ty, Vocabulary};

/// Removes keys with default values from the canonical fields of a stage.
pub fn strip(fields: &mut Json) {
    static LANGUAGE: OnceLock<Vocabulary> = OnceLock::new();
    let language = LANGUAGE.get_or_init(vocabulary);
    for (name, value) in fields.as_object_mut().into_iter().flatten() {
        let Some(table) = value.as_object_mut() else { continue };
        let shape =
            language.sections.iter().find(|section| section.name == name).map(|section| &section.shape);
        match shape {
            Some(Shape::Plain(params)) => strip_keys(table, params),
            Some(Shape::Kind(kinds)) => strip_kind(table, None, kinds),
            // The stage of a single term has the term in place of its section.
            Some(Shape::Terms(kinds, _)) if table.get("kind").is_some_and(Json::is_string) => {
                strip_kind(table, None, kinds);
            }
            Some(Shape::Terms(kinds, extra)) => {
                strip_terms(table, kinds);
                table.values_mut().filter_map(Json::as_object_mut).for_each(|term| strip_keys(term, extra));
            }
            None if name == "motion" => strip_kind(table, None, &motion::kinds()),
            None => {}
        }
    }
}

/// Named terms of these kinds.
fn strip_terms(terms: &mut Map<String, Json>, kinds: &[&'static Kind]) {
    for (name, term) in terms {
        if let Some(term) = term.as_object_mut() {
            strip_kind(term, Some(name), kinds);
        }
    }
}

/// A table of one of these kinds, or a part of one without the key `kind`.
fn strip_kind(table: &mut Map<String, Json>, name: Option<&str>, kinds: &[&'static Kind]) {
    let kind = table.get("kind").and_then(Json::as_str).or(name);
    match kinds.iter().find(|known| Some(known.name) == kind) {
        Some(kind) => strip_keys(table, kind.params),
        None => kinds.iter().for_each(|kind| strip_keys(table, kind.params)),
    }
}

fn strip_keys(table: &mut Map<String, Json>, params: &[Param]) {
    for param in params {
        let Some(value) = table.get_mut(param.name) else { continue };
        strip_value(value, &param.ty);
        let Presence::Default(_) = param.presence else { continue };
        if default_value(param).is_some_and(|default| is_default(value, default.canonical(), &param.ty)) {
            table.shift_remove(param.name);
        }
    }
}

fn is_default(value: &Json, mut default: Json, ty: &Ty) -> bool {
    strip_value(&mut default, ty);
    canonical_json(value) == canonical_json(&default)
}

/// Removes defaults inside a value of a type.
fn strip_value(value: &mut Json, ty: &Ty) {
    match (ty, value) {
        (Ty::Table(params), Json::Object(table)) => strip_keys(table, params),
        (Ty::Named(item), Json::Object(table)) => {
            table.values_mut().for_each(|value| strip_value(value, item))
        }
        (Ty::Kind(kinds), Json::Object(table)) => strip_kind(table, None, &(kinds.all)()),
        (Ty::Terms(kinds), Json::Object(table)) => strip_terms(table, &(kinds.all)()),
        (Ty::List(item), Json::Array(items)) => items.iter_mut().for_each(|value| strip_value(value, item)),
        (Ty::OneOf(types), value) => {
            if let Some(ty) = types.iter().find(|ty| fits(ty, value)) {
                strip_value(value, ty);
            }
        }
        _ => {}
    }
}

/// Whether a decoded table or list matches a type. Other values have no parts.
fn fits(ty: &Ty, value: &Json) -> bool {
    match (ty, value) {
        (Ty::Table(params), Json::Object(table)) => {
            table.keys().all(|key| params.iter().any(|param| param.name == key))
        }
        (Ty::Kind(kinds), Json::Object(table)) => {
            let kind = table.get("kind").and_then(Json::as_str);
            (kinds.all)().iter().any(|known| Some(known.name) == kind)
        }
        (Ty::Terms(_) | Ty::Named(_), Json::Object(table)) => table.values().all(Json::is_object),
        (Ty::List(item), Json::Array(items)) => items.iter().all(|value| fits(item, value)),
        (Ty::OneOf(types), value) => types.iter().any(|ty| fits(ty, value)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn stripped(mut fields: Json) -> Json {
        strip(&mut fields);
        fields
    }

    #[test]
    fn keys_with_their_defaults_are_left_out_and_others_stay() {
        let fields = json!({
            "learn": {
                "kind": "ppo", "gamma": 0.99, "lambda": 0.9, "epochs": 3.0, "seed": 2,
                "policy": { "hidden": [256, 256], "activation": "relu" },
                "value": { "hidden": [256, 256], "activation": "tanh", "learning_rate": 5e-4,
                    "privileged": false },
            },
        });
        let left = json!({ "learn": { "kind": "ppo", "lambda": 0.9, "seed": 2,
                    "value": { "activation": "tanh" } } });
        assert_eq!(stripped(fields), left);
    }

    #[test]
    fn a_part_of_a_section_is_read_as_the_whole_is() {
        let fields =
            json!({ "learn": { "seed": 1, "symmetry": "none", "policy": { "hidden": [256, 256] } } });
        assert_eq!(stripped(fields), json!({ "learn": {} }));
        let fields = json!({ "task": { "kind": "walk", "command": { "speed": 0.5, "ramp": 0 } } });
        assert_eq!(stripped(fields), json!({ "task": { "kind": "walk", "command": { "speed": 0.5 } } }));
    }

    #[test]
    fn terms_are_read_under_their_names_their_kinds_and_as_a_stage_of_their_own() {
        let term = json!({ "kind": "joint_friction", "scale": { "uniform": [0.6, 1.4] }, "per": "joint" });
        let left = json!({ "kind": "joint_friction", "scale": { "uniform": [0.6, 1.4] } });
        let fields = json!({ "randomize": { "joint_friction": term, "other": term } });
        assert_eq!(stripped(fields), json!({ "randomize": { "joint_friction": left, "other": left } }));
        // The same rows inside an evaluation, which is a separate stage.
        let fields =
            json!({ "evaluate": { "kind": "episodes", "episodes": 32, "randomize": { "drag": term } } });
        assert_eq!(
            stripped(fields),
            json!({ "evaluate": { "kind": "episodes", "randomize": { "drag": left } } })
        );
        let ground = json!({ "kind": "box_obstacle", "height": 0.02, "length": 0.4, "width": 8,
                "reference": "front" });
        let fields = json!({ "evaluate": { "kind": "episodes", "episodes": 8, "terrain": ground } });
        let left = json!({ "kind": "box_obstacle", "height": 0.02, "reference": "front" });
        assert_eq!(
            stripped(fields),
            json!({ "evaluate": { "kind": "episodes", "episodes": 8, "terrain": left } })
        );
    }
}
