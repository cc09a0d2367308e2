//! The schema of a suite: the sections that its arms share, the sweep over their differences, and the claims.

use serde_json::{Map, Value, json};

use super::table::{self, Keys};
use super::{Definitions, described, finished, spec};
use crate::kinds::vocabulary::vocabulary;
use crate::spec::section::Header;
use crate::spec::typed::Keys as _;
use crate::spec::{Param, Ty, claim};

/// Keys of a suite that specs do not have.
const OWN: &[Param] = &[
    Param::required("suite", Ty::Text).doc("The suite's name, in place of a spec's."),
    Param::default("claims", Ty::Choice(&["report", "count"]), "\"report\"")
        .doc("Effect of a failed claim: `report` only reports it, `count` ends the run with exit code 5."),
];

/// The schema.
pub fn document() -> Value {
    let mut definitions = Definitions::new(Keys::Some);
    let sections = spec::sections(&vocabulary(), &mut definitions);
    let mut properties = spec::header(&mut definitions);
    properties.retain(|key, _| !Header::OF_SPECS.contains(&key.as_str()));
    for param in OWN {
        properties.insert(param.name.to_owned(), table::key(param, &mut definitions));
    }
    let extends = properties[Header::extends.name].clone();
    properties.extend(sections.clone());
    properties.insert("sweep".to_owned(), sweep(point(&sections, extends)));
    let claims = table::plain(claim::keys::Claim::PARAMS, Keys::All, &mut definitions);
    let claims = json!({ "type": "array", "items": claims });
    properties.insert("claim".to_owned(), described(claims, "What the suite is expected to show."));
    properties.insert("allow".to_owned(), spec::allow());
    properties.insert("profile".to_owned(), profiles(sections, &properties["claims"]));
    let body = json!({
        "type": "object",
        "properties": properties,
        "required": ["spec", "suite"],
        "additionalProperties": false,
    });
    let text = "A suite: specs multiplied over the axes of a sweep, and what they are expected to show.";
    finished("specforge suite, edition 1", text, body, definitions)
}

/// A point of an axis: parents and assignments.
fn point(sections: &Map<String, Value>, extends: Value) -> Value {
    let mut properties = sections.clone();
    properties.insert("extends".to_owned(), extends);
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// `[sweep]`: seeds, zipped axes, the selected combinations, and the axes.
fn sweep(point: Value) -> Value {
    let names = json!({ "type": "array", "items": { "type": "string" }, "minItems": 1 });
    let patterns = json!({ "type": "array", "items": { "type": "object", "minProperties": 1 } });
    let by_value = json!({
        "properties": { "path": { "type": "string" }, "values": { "type": "array", "minItems": 1 } },
        "required": ["path", "values"],
        "additionalProperties": false,
    });
    let by_name = json!({ "additionalProperties": point });
    let has_values = json!({ "anyOf": [{ "required": ["path"] }, { "required": ["values"] }] });
    let axis =
        json!({ "type": "object", "minProperties": 1, "if": has_values, "then": by_value, "else": by_name });
    let zip = json!({ "type": "array", "items": { "anyOf": [{ "type": "string" }, names] } });
    let properties = json!({
        "seeds": seeds(),
        "zip": described(zip, "Axes that advance together, point by point."),
        "include": described(patterns.clone(), "Only combinations that match one of these are run."),
        "exclude": described(patterns, "Combinations that match one of these are left out."),
    });
    let axis = described(axis, "An axis: `path` and `values`, or a table for each point.");
    json!({ "type": "object", "properties": properties, "additionalProperties": axis })
}

fn seeds() -> Value {
    let list = json!({ "type": "array", "items": { "type": "integer", "minimum": 0 }, "minItems": 1 });
    let count = json!({ "type": "integer", "minimum": 1, "maximum": 1000 });
    described(json!({ "anyOf": [count, list] }), "The learning seeds of every arm: their number, or a list.")
}

/// The profiles: overlays that may also change the seeds and the effect of a failed claim.
fn profiles(mut sections: Map<String, Value>, claims: &Value) -> Value {
    sections.remove("report");
    let seeds =
        json!({ "type": "object", "properties": { "seeds": seeds() }, "additionalProperties": false });
    sections.insert("sweep".to_owned(), seeds);
    sections.insert("claims".to_owned(), claims.clone());
    let keys = spec::overlay_keys(sections);
    let overlay = json!({ "type": "object", "properties": keys, "additionalProperties": false });
    let schema = json!({ "type": "object", "additionalProperties": overlay });
    described(schema, "Overlays, each chosen by `--profile NAME`.")
}
