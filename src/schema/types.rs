//! The types of single values as schemas, and the bounds of a key. Independent of tables.

use serde_json::{Map, Value, json};

use super::{Definitions, described, pattern};
use crate::quantity::Dimension;
use crate::spec::{Length, Sampler, Ty};

/// Adds the length of a list; for a value with several forms, to those that are lists.
pub fn measure(schema: &mut Value, length: Length) {
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

/// Whether values of a type are numbers without a unit, so that a schema can check their bounds.
pub fn takes_bare_numbers(ty: &Ty) -> bool {
    matches!(ty, Ty::Count | Ty::Number | Ty::Quantity(Dimension::NONE) | Ty::Sampler(Dimension::NONE))
}

/// A bound, as an integer if it is whole.
pub fn number(value: f64) -> Value {
    let whole = value as i64;
    if whole as f64 == value && value.abs() < 1e15 { json!(whole) } else { json!(value) }
}

/// A quantity: one definition per dimension; a pure number may be a TOML number.
pub fn quantity(dimension: Dimension, definitions: &mut Definitions) -> Value {
    if dimension == Dimension::NONE {
        return json!({ "type": ["number", "string"], "pattern": pattern::ratio() });
    }
    definitions.refer(
        &format!("quantity.{}", slug(dimension)),
        |_| json!({ "type": "string", "pattern": pattern::quantity(dimension) }),
    )
}

/// A plain quantity or a distribution: the keywords for strings, numbers and tables are independent of each
/// other.
pub fn sampler(dimension: Dimension, definitions: &mut Definitions) -> Value {
    definitions.refer(&format!("sampler.{}", slug(dimension)), |definitions| {
        let item = quantity(dimension, definitions);
        let mut forms = Map::new();
        for word in Sampler::WORDS {
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

/// Description of a distribution, for a hover.
fn distribution(word: &str) -> &'static str {
    match word {
        "uniform" => "Uniform between the two ends.",
        "log_uniform" => "Uniform in the logarithm between the two ends.",
        "normal" => "Normal with a mean and a standard deviation.",
        _ => "One of the values with equal probability.",
    }
}

/// `a joint damping` as `joint_damping`; a dimension without a name by its unit.
fn slug(dimension: Dimension) -> String {
    let name = dimension.name();
    let name = name.strip_prefix("an ").or(name.strip_prefix("a ")).unwrap_or(&name);
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect()
}
