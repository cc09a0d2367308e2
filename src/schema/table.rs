//! Tables as schemas, with the values of their keys: plain tables, tables of a kind, and named terms.

use serde_json::{Map, Value, json};

use super::{Definitions, described, pattern, types};
use crate::kinds::reference::summary;
use crate::spec::{Kind, Kinds, Param, Presence, Share, Ty};

/// Which keys are required.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keys {
    /// None: a parent may contain the others.
    Some,
    /// All that are required.
    All,
}

/// A table with these keys and no others.
pub fn plain(params: &[Param], keys: Keys, definitions: &mut Definitions) -> Value {
    let properties: Map<String, Value> =
        params.iter().map(|param| (param.name.to_owned(), key(param, definitions))).collect();
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    let required = required(params);
    if keys == Keys::All && !required.is_empty() {
        schema["required"] = json!(required);
    }
    schema
}

/// The schema of a key's value, with its documentation, default, bounds and length.
pub fn key(param: &Param, definitions: &mut Definitions) -> Value {
    let mut schema = described(of(&param.ty, definitions), &documentation(param));
    if let (Some((low, high)), true) = (param.range, types::takes_bare_numbers(&param.ty)) {
        schema["minimum"] = types::number(low);
        schema["maximum"] = types::number(high);
    }
    if let Some(length) = param.length {
        types::measure(&mut schema, length);
    }
    if let Presence::Default(text) = param.presence
        && let Ok(mut parsed) = toml::from_str::<Map<String, Value>>(&format!("value = {text}"))
        && let Some(value) = parsed.remove("value")
    {
        schema["default"] = value;
    }
    schema
}

/// The documentation of a key, including the reference of a ratio.
fn documentation(param: &Param) -> String {
    match param.ty {
        Ty::Ratio(Share { of, measure: None }) => format!("{} A share of {of}.", param.doc),
        Ty::Ratio(Share { of, measure: Some(measure) }) => {
            format!("{} A share of {of}, or {} in `{}`.", param.doc, measure.name(), measure.unit())
        }
        _ => param.doc.to_owned(),
    }
}

/// The schema of a type.
pub fn of(ty: &Ty, definitions: &mut Definitions) -> Value {
    match ty {
        Ty::Flag => json!({ "type": "boolean" }),
        Ty::Count => definitions.refer(
            "count",
            |_| json!({ "type": ["integer", "string"], "minimum": 0, "pattern": pattern::count() }),
        ),
        Ty::Number => json!({ "type": "number" }),
        Ty::Quantity(dimension) => types::quantity(*dimension, definitions),
        Ty::Ratio(Share { measure: None, .. }) => {
            definitions.refer("ratio", |_| json!({ "type": "string", "pattern": pattern::ratio() }))
        }
        Ty::Ratio(Share { measure: Some(measure), .. }) => {
            json!({ "type": "string", "pattern": pattern::ratio_or(*measure) })
        }
        Ty::Text => json!({ "type": "string" }),
        Ty::Choice(words) => json!({ "enum": words }),
        Ty::Sampler(dimension) => types::sampler(*dimension, definitions),
        Ty::List(item) => {
            let items = of(item, definitions);
            json!({ "type": "array", "items": items })
        }
        Ty::Table(params) => plain(params, definitions.keys, definitions),
        Ty::Named(item) => {
            let values = of(item, definitions);
            json!({ "type": "object", "additionalProperties": values })
        }
        Ty::Kind(kinds) => definitions.refer(&format!("table.{}", kinds.section), |definitions| {
            place(*kinds, &(kinds.all)(), false).of_any_kind(definitions)
        }),
        Ty::Terms(kinds) => definitions.refer(&format!("tables.{}", kinds.section), |definitions| {
            place(*kinds, &(kinds.all)(), true).of_terms(definitions)
        }),
        Ty::OneOf(types) => {
            let forms: Vec<Value> = types.iter().map(|ty| of(ty, definitions)).collect();
            json!({ "anyOf": forms })
        }
    }
}

/// The context of kinds inside a table.
fn place<'a>(kinds: Kinds, all: &'a [&'static Kind], switched: bool) -> Place<'a> {
    Place { name: kinds.section, noun: kinds.noun, kinds: all, extra: &[], switched }
}

/// The required keys.
pub fn required(params: &[Param]) -> Vec<&'static str> {
    params
        .iter()
        .filter(|param| matches!(param.presence, Presence::Required))
        .map(|param| param.name)
        .collect()
}

/// The kinds that are allowed in one context.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The section.
    pub name: &'static str,
    /// What its kinds are called: `reward term`.
    pub noun: &'static str,
    /// The kinds.
    pub kinds: &'a [&'static Kind],
    /// Keys that all of them take.
    pub extra: &'static [Param],
    /// Whether a table can be switched off.
    pub switched: bool,
}

impl Place<'_> {
    /// A table of any of the kinds. The keys of all kinds are in one list, for completion; kind-specific
    /// rules are in one branch per kind.
    pub fn of_any_kind(&self, definitions: &mut Definitions) -> Value {
        let mut properties = Map::new();
        properties.insert("kind".to_owned(), self.kind_key());
        if self.switched {
            let text =
                format!("`false` switches this {} off, for example one that a parent sets.", self.noun);
            properties.insert("enabled".to_owned(), described(json!({ "type": "boolean" }), &text));
        }
        for param in self.extra {
            properties.insert(param.name.to_owned(), key(param, definitions));
        }
        for name in self.keys() {
            let key = self.common(name, definitions);
            properties.insert(name.to_owned(), key);
        }
        let branches: Vec<Value> = self.kinds.iter().map(|kind| self.branch(kind, definitions)).collect();
        json!({ "type": "object", "properties": properties, "additionalProperties": false,
                "allOf": branches })
    }

    /// Named terms, each of any of the kinds.
    pub fn of_terms(&self, definitions: &mut Definitions) -> Value {
        let any = definitions.refer(&format!("term.{}", self.name), |inner| self.of_any_kind(inner));
        let named: Map<String, Value> = self
            .kinds
            .iter()
            .map(|kind| (kind.name.to_owned(), self.named(kind, &any, definitions)))
            .collect();
        json!({ "type": "object", "properties": named, "additionalProperties": any })
    }

    /// A term whose table is named after a kind has that kind unless it sets `kind`.
    fn named(&self, kind: &'static Kind, any: &Value, definitions: &mut Definitions) -> Value {
        let own = self.of_kind(kind, definitions);
        let unless_said = json!({ "not": { "required": ["kind"] } });
        let own = json!({ "if": unless_said, "then": own, "additionalProperties": true });
        described(json!({ "allOf": [any, own], "additionalProperties": true }), summary(kind))
    }

    /// The key `kind`.
    fn kind_key(&self) -> Value {
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name).collect();
        let lines: Vec<String> =
            self.kinds.iter().map(|kind| format!("`{}`: {}", kind.name, summary(kind))).collect();
        described(json!({ "enum": names }), &lines.join("\n\n"))
    }

    /// The names of the keys of all kinds, each once.
    fn keys(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for param in self.kinds.iter().flat_map(|kind| kind.params) {
            if !names.contains(&param.name) {
                names.push(param.name);
            }
        }
        names
    }

    /// The common part of a key's schema over all kinds that have it; if they differ, only the documentation
    /// remains. Some editors treat a schema as closed unless it says that it is open.
    fn common(&self, name: &str, definitions: &mut Definitions) -> Value {
        let mut meanings: Vec<(Vec<&str>, Value)> = Vec::new();
        for kind in self.kinds {
            let Some(param) = kind.params.iter().find(|param| param.name == name) else { continue };
            let schema = key(param, definitions);
            match meanings.iter_mut().find(|(_, known)| *known == schema) {
                Some((kinds, _)) => kinds.push(kind.name),
                None => meanings.push((vec![kind.name], schema)),
            }
        }
        if let [(_, schema)] = meanings.as_slice() {
            return schema.clone();
        }
        let text = |schema: &Value| schema["description"].as_str().unwrap_or_default().to_owned();
        let line =
            |(kinds, schema): &(Vec<&str>, Value)| format!("`{}`: {}", kinds.join("`, `"), text(schema));
        let lines: Vec<String> = meanings.iter().map(line).collect();
        let shape = match meanings.iter().map(|(_, schema)| undocumented(schema)).reduce(same) {
            Some(Value::Object(shape)) => Value::Object(shape),
            _ => json!({ "additionalProperties": true }),
        };
        described(shape, &lines.join("\n\n"))
    }

    /// Rules for a table with a given kind.
    fn branch(&self, kind: &'static Kind, definitions: &mut Definitions) -> Value {
        let own = self.of_kind(kind, definitions);
        let said = json!({ "properties": { "kind": { "const": kind.name } }, "required": ["kind"] });
        json!({ "if": said, "then": own, "additionalProperties": true })
    }

    /// Additional rules for a table of a kind: its own types, and no keys of other kinds.
    fn of_kind(&self, kind: &'static Kind, definitions: &mut Definitions) -> Value {
        let this = *self;
        definitions.refer(&format!("kind.{}.{}", self.name, kind.name), |definitions| {
            let mut properties = Map::new();
            for name in this.keys() {
                match kind.params.iter().find(|param| param.name == name) {
                    None => {
                        properties.insert(name.to_owned(), json!(false));
                    }
                    Some(param) => {
                        let schema = key(param, definitions);
                        if undocumented(&schema) != undocumented(&this.common(name, definitions)) {
                            properties.insert(name.to_owned(), schema);
                        }
                    }
                }
            }
            json!({ "description": summary(kind), "properties": properties, "additionalProperties": true })
        })
    }

    /// Required keys of a table without inheritance: those of its explicit kind, or of the kind with its
    /// name.
    pub fn complete(&self, named: Option<&'static Kind>, definitions: &mut Definitions) -> Value {
        let said = self.complete_as_said(definitions);
        let mut demands = said.map(|said| vec![said]).unwrap_or_default();
        let unless_said = match named {
            None => json!({ "required": ["kind"], "additionalProperties": true }),
            Some(kind) => demand(self.needed(kind), json!({ "not": { "required": ["kind"] } })),
        };
        demands.push(unless_said);
        json!({ "allOf": demands, "additionalProperties": true })
    }

    /// Required keys of a table with an explicit kind; `None` if no kind has any.
    fn complete_as_said(&self, definitions: &mut Definitions) -> Option<Value> {
        let said =
            |kind: &Kind| json!({ "properties": { "kind": { "const": kind.name } }, "required": ["kind"] });
        let needing = self.kinds.iter().filter(|kind| !self.needed(kind).is_empty());
        let branches: Vec<Value> = needing.map(|kind| demand(self.needed(kind), said(kind))).collect();
        if branches.is_empty() {
            return None;
        }
        let name = format!("complete.{}", self.name);
        Some(definitions.refer(&name, |_| json!({ "allOf": branches, "additionalProperties": true })))
    }

    /// The required keys of a table of a kind.
    fn needed(&self, kind: &Kind) -> Vec<&'static str> {
        [required(kind.params), required(self.extra)].concat()
    }
}

/// Keys that are required under a condition.
fn demand(keys: Vec<&'static str>, condition: Value) -> Value {
    json!({ "if": condition, "then": { "required": keys, "additionalProperties": true },
            "additionalProperties": true })
}

/// A schema without its documentation.
fn undocumented(schema: &Value) -> Value {
    let mut schema = schema.clone();
    if let Some(object) = schema.as_object_mut() {
        object.remove("description");
    }
    schema
}

/// The common part of two schemas: everything or nothing.
fn same(first: Value, second: Value) -> Value {
    if first == second { first } else { Value::Null }
}
