//! The schema of a spec.

use serde_json::{Map, Value, json};

use super::table::{self, Keys, Place};
use super::{Definitions, described, finished};
use crate::diag::codes::PAGES;
use crate::kinds::reference::registries;
use crate::kinds::vocabulary::vocabulary;
use crate::spec::section::Header;
use crate::spec::typed::Keys as _;
use crate::spec::{SectionShape, Shape, Vocabulary};

/// Keys that name a file of the project, with the key whose shipped names complete them.
const NAMES: [(&str, &str); 2] = [("robot", "model"), ("task", "motion")];

/// The schema.
pub fn document() -> Value {
    let vocabulary = vocabulary();
    let mut definitions = Definitions::new(Keys::Some);
    let sections = sections(&vocabulary, &mut definitions);
    let overlay = definitions.refer(
        "overlay",
        |_| json!({ "type": "object", "properties": overlay_keys(sections.clone()), "additionalProperties": false }),
    );
    let mut properties = header(&mut definitions);
    properties.extend(sections.clone());
    properties.insert("allow".to_owned(), allow());
    let profiles = json!({ "type": "object", "additionalProperties": overlay });
    properties
        .insert("profile".to_owned(), described(profiles, "Overlays, each chosen by `--profile NAME`."));
    let body = json!({
        "type": "object",
        "properties": properties,
        "required": ["spec"],
        "additionalProperties": false,
        "if": { "not": { "anyOf": [
            { "required": ["extends"] },
            { "properties": { "abstract": { "const": true } }, "required": ["abstract"] },
        ] } },
        "then": complete(&vocabulary, &mut definitions),
    });
    let text = "An experiment, or a parent of experiments. Keys that a parent sets may be left out.";
    finished("specforge spec, edition 1", text, body, definitions)
}

/// The sections, as a part of a spec or of a profile.
pub fn sections(vocabulary: &Vocabulary, definitions: &mut Definitions) -> Map<String, Value> {
    let shapes = vocabulary.sections.iter();
    shapes.map(|shape| (shape.name.to_owned(), section(shape, vocabulary, definitions))).collect()
}

/// The keys of a profile: the sections, and the profile that it extends.
pub fn overlay_keys(mut sections: Map<String, Value>) -> Map<String, Value> {
    let extends = described(json!({ "type": "string" }), "The profile on top of which this one applies.");
    sections.insert("extends".to_owned(), extends);
    sections
}

/// The keys before the sections.
pub fn header(definitions: &mut Definitions) -> Map<String, Value> {
    let params = Header::PARAMS.iter().filter(|param| !Header::AROUND_SECTIONS.contains(&param.name));
    let mut keys: Map<String, Value> =
        params.map(|param| (param.name.to_owned(), table::key(param, definitions))).collect();
    let edition =
        described(json!({ "const": 1 }), keys[Header::spec.name]["description"].as_str().unwrap_or_default());
    keys.insert(Header::spec.name.to_owned(), edition);
    keys
}

/// The warnings that may be allowed, each with a reason.
pub fn allow() -> Value {
    let codes = PAGES.iter().filter(|page| page.code.starts_with('W'));
    let reason = |title: &str| described(json!({ "type": "string", "pattern": r"\S" }), title);
    let properties: Map<String, Value> =
        codes.map(|page| (page.code.to_owned(), reason(page.title()))).collect();
    let schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    described(schema, "Accepted warnings, each with its reason.")
}

/// The context of a section's kinds.
fn place(shape: &SectionShape) -> Option<Place<'_>> {
    let (kinds, extra, switched) = match &shape.shape {
        Shape::Plain(_) => return None,
        Shape::Kind(kinds) => (kinds, &[] as &[_], !shape.required),
        Shape::Terms(kinds, extra) => (kinds, *extra, true),
    };
    Some(Place { name: shape.name, noun: shape.noun, kinds, extra, switched })
}

/// A section as a part of a spec or of a profile.
fn section(shape: &SectionShape, vocabulary: &Vocabulary, definitions: &mut Definitions) -> Value {
    let text = registries()
        .iter()
        .find(|registry| registry.name == shape.name)
        .map_or("", |registry| registry.summary);
    definitions.refer(&format!("section.{}", shape.name), |definitions| {
        let schema = match (&shape.shape, place(shape)) {
            (Shape::Terms(..), Some(place)) => place.of_terms(definitions),
            (_, Some(place)) => place.of_any_kind(definitions),
            (Shape::Plain(params), None) => table::plain(params, Keys::Some, definitions),
            (_, None) => json!({}),
        };
        described(with_names(schema, shape.name, vocabulary), text)
    })
}

/// The same schema with the names of shipped files, for completion.
fn with_names(mut schema: Value, section: &str, vocabulary: &Vocabulary) -> Value {
    for (_, key) in NAMES.iter().filter(|(named, _)| *named == section) {
        let files = if section == "robot" { &vocabulary.robots } else { &vocabulary.motions };
        let names: Vec<&str> = files.iter().map(|file| file.name).collect();
        let property = &mut schema["properties"][*key];
        let text = property["description"].as_str().unwrap_or_default().to_owned();
        *property = described(json!({ "anyOf": [{ "enum": names }, { "type": "string" }] }), &text);
    }
    schema
}

/// Keys that a spec without parents must contain.
fn complete(vocabulary: &Vocabulary, definitions: &mut Definitions) -> Value {
    let required: Vec<&str> =
        vocabulary.sections.iter().filter(|shape| shape.required).map(|shape| shape.name).collect();
    let mut properties = Map::new();
    for shape in &vocabulary.sections {
        let demand = match (&shape.shape, place(shape)) {
            (Shape::Plain(params), _) => {
                json!({ "required": table::required(params), "additionalProperties": true })
            }
            (Shape::Terms(kinds, _), Some(place)) => {
                let named: Map<String, Value> = kinds
                    .iter()
                    .map(|kind| (kind.name.to_owned(), place.complete(Some(kind), definitions)))
                    .collect();
                json!({ "properties": named, "additionalProperties": place.complete(None, definitions) })
            }
            (_, Some(place)) => place.complete(None, definitions),
            (_, None) => continue,
        };
        properties.insert(shape.name.to_owned(), demand);
    }
    json!({ "required": required, "properties": properties, "additionalProperties": true })
}
