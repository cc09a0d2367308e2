//! The types of values as schemas.

use serde_json::{Map, Value, json};

use super::table::{self, Place};
use super::{Definitions, described, pattern};
use crate::quantity::Dimension;
use crate::spec::decode::DISTRIBUTIONS;
use crate::spec::{Kind, Kinds, Length, Param, Presence, Ty};

/// The schema of a key's value, with its documentation, default, bounds and length.
pub fn key(param: &Param, definitions: &mut Definitions) -> Value {
    let mut schema = described(of(&param.ty, definitions), &documentation(param));
    if let (Some((low, high)), true) = (param.range, takes_bare_numbers(&param.ty)) {
        schema["minimum"] = number(low);
        schema["maximum"] = number(high);
    }
    if let Some(length) = param.length {
        measure(&mut schema, length);
    }
    if let Presence::Default(text) = param.presence
        && let Ok(mut parsed) = toml::from_str::<Map<String, Value>>(&format!("value = {text}"))
        && let Some(value) = parsed.remove("value")
    {
        schema["default"] = value;
    }
    schema
}

/// Says how many items a list has; of a value that has several forms, in those that are lists.
fn measure(schema: &mut Value, length: Length) {
    let items = |least: usize, most: usize| json!({ "minItems": least, "maxItems": most });
    let bounds = match length {
        Length::Some => json!({ "minItems": 1 }),
        Length::Each(names) => items(names.len(), names.len()),
        Length::OneOrEach(names) => json!({ "anyOf": [items(1, 1), items(names.len(), names.len())] }),
    };
    if schema["type"] == "array"
        && let (Some(list), Value::Object(bounds)) = (schema.as_object_mut(), bounds)
    {
        list.extend(bounds);
    } else if let Some(forms) = schema.get_mut("anyOf").and_then(Value::as_array_mut) {
        forms.iter_mut().for_each(|form| measure(form, length));
    }
}

/// The documentation of a key, with what a ratio refers to.
fn documentation(param: &Param) -> String {
    match param.ty {
        Ty::Ratio(reference) => format!("{} A share of {reference}.", param.doc),
        _ => param.doc.to_owned(),
    }
}

/// Whether values of a type are numbers without a unit, whose bounds a schema can check.
fn takes_bare_numbers(ty: &Ty) -> bool {
    matches!(ty, Ty::Count | Ty::Number | Ty::Quantity(Dimension::NONE) | Ty::Sampler(Dimension::NONE))
}

/// A bound, whole where it is.
fn number(value: f64) -> Value {
    let whole = value as i64;
    if whole as f64 == value && value.abs() < 1e15 { json!(whole) } else { json!(value) }
}

/// The schema of a type.
pub fn of(ty: &Ty, definitions: &mut Definitions) -> Value {
    match ty {
        Ty::Flag => json!({ "type": "boolean" }),
        Ty::Count => definitions
            .refer("count", |_| json!({ "type": ["integer", "string"], "minimum": 0, "pattern": pattern::count() })),
        Ty::Number => json!({ "type": "number" }),
        Ty::Quantity(Dimension::NONE) => json!({ "type": ["number", "string"], "pattern": pattern::ratio() }),
        Ty::Quantity(dimension) => quantity(*dimension, definitions),
        Ty::Ratio(_) => definitions.refer("ratio", |_| json!({ "type": "string", "pattern": pattern::ratio() })),
        Ty::Text => json!({ "type": "string" }),
        Ty::Choice(words) => json!({ "enum": words }),
        Ty::Sampler(dimension) => sampler(*dimension, definitions),
        Ty::List(item) => {
            let items = of(item, definitions);
            json!({ "type": "array", "items": items })
        }
        Ty::Table(params) => table::plain(params, definitions.keys, definitions),
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

/// The place of kinds inside a table.
fn place<'a>(kinds: Kinds, all: &'a [&'static Kind], switched: bool) -> Place<'a> {
    Place { name: kinds.section, noun: kinds.noun, kinds: all, extra: &[], switched }
}

/// A quantity: one definition per dimension.
fn quantity(dimension: Dimension, definitions: &mut Definitions) -> Value {
    definitions.refer(
        &format!("quantity.{}", slug(dimension)),
        |_| json!({ "type": "string", "pattern": pattern::quantity(dimension) }),
    )
}

/// A plain quantity or a distribution: the keywords for strings, numbers and tables do not disturb each other.
fn sampler(dimension: Dimension, definitions: &mut Definitions) -> Value {
    definitions.refer(&format!("sampler.{}", slug(dimension)), |definitions| {
        let item = of(&Ty::Quantity(dimension), definitions);
        let mut forms = Map::new();
        for word in DISTRIBUTIONS {
            let list = match *word {
                "choice" => json!({ "type": "array", "items": item, "minItems": 1 }),
                _ => json!({ "type": "array", "items": item, "minItems": 2, "maxItems": 2 }),
            };
            forms.insert((*word).to_owned(), described(list, distribution(word)));
        }
        let mut schema = match dimension {
            Dimension::NONE => json!({ "type": ["number", "string", "object"], "pattern": pattern::ratio() }),
            _ => json!({ "type": ["string", "object"], "pattern": pattern::quantity(dimension) }),
        };
        schema["properties"] = Value::Object(forms);
        schema["additionalProperties"] = json!(false);
        schema["minProperties"] = json!(1);
        schema["maxProperties"] = json!(1);
        schema
    })
}

/// What a distribution is, for a hover.
fn distribution(word: &str) -> &'static str {
    match word {
        "uniform" => "Uniform between the two ends.",
        "log_uniform" => "Uniform in the logarithm between the two ends.",
        "normal" => "Normal with a mean and a standard deviation.",
        _ => "One of the values with equal chance.",
    }
}

/// `a joint damping` as `joint_damping`; a dimension without a name by its unit.
fn slug(dimension: Dimension) -> String {
    let name = dimension.name();
    let name = name.strip_prefix("an ").or(name.strip_prefix("a ")).unwrap_or(&name);
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect()
}
