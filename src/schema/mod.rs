//! JSON Schemas of specforge's files, for editors: generated from the descriptors, committed under
//! `specs/schema/`.
//!
//! A schema accepts what `specforge check` accepts of a single file, as far as one file shows: a child may
//! leave out keys that a parent sets, so only a spec without parents must be complete. Independent of the
//! meaning of specs.

mod pattern;
mod robot;
mod spec;
mod suite;
mod table;
mod types;

use serde_json::{Map, Value, json};
use table::Keys;

/// A schema with the name of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Schema {
    /// `spec-1.json`.
    pub file: &'static str,
    /// What it describes: `spec`.
    pub subject: &'static str,
    /// The schema.
    pub document: Value,
}

impl Schema {
    /// The file's text.
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(&self.document).expect("a JSON value has a text");
        text + "\n"
    }
}

/// The schemas of this version.
pub fn schemas() -> Vec<Schema> {
    let schema = |file, subject, document| Schema { file, subject, document };
    vec![
        schema("spec-1.json", "spec", spec::document()),
        schema("suite-1.json", "suite", suite::document()),
        schema("motion-1.json", "motion", robot::motion()),
        schema("robot-1.json", "robot", robot::robot()),
    ]
}

/// The definitions that a document refers to, by name.
#[derive(Clone, Debug)]
struct Definitions {
    map: Map<String, Value>,
    /// Which keys nested tables must contain.
    keys: Keys,
}

impl Definitions {
    /// No definitions yet.
    fn new(keys: Keys) -> Self {
        Self { map: Map::new(), keys }
    }

    /// A reference to a definition, which is created on first use.
    fn refer(&mut self, name: &str, make: impl FnOnce(&mut Self) -> Value) -> Value {
        if !self.map.contains_key(name) {
            // The entry is reserved first, so that definitions are in the order of their first use.
            self.map.insert(name.to_owned(), Value::Null);
            let made = make(self);
            self.map.insert(name.to_owned(), made);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }
}

/// A document with its definitions.
fn finished(title: &str, description: &str, body: Value, definitions: Definitions) -> Value {
    let mut document = Map::new();
    document.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
    document.insert("title".to_owned(), json!(title));
    document.insert("description".to_owned(), json!(description));
    if let Value::Object(body) = body {
        document.extend(body);
    }
    document.insert("$defs".to_owned(), Value::Object(definitions.map));
    Value::Object(document)
}

/// The same schema with a description.
fn described(mut schema: Value, description: &str) -> Value {
    if let (Some(object), false) = (schema.as_object_mut(), description.is_empty()) {
        object.insert("description".to_owned(), json!(description));
    }
    schema
}

#[cfg(test)]
mod tests;
