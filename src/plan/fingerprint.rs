//! Fingerprints: everything that a stage's result depends on, as data that can be stored, compared and
//! hashed.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::shared::Shared;

/// BLAKE3 of a recipe's canonical JSON, as 64 hexadecimal digits. It is the stage's key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Fingerprint(String);

impl Fingerprint {
    /// Parses a fingerprint in the form of [`fmt::Display`].
    pub fn parse(text: &str) -> Option<Self> {
        let valid = text.len() == 64 && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        valid.then(|| Self(text.to_owned()))
    }

    /// All digits.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The first twelve digits, for display.
    pub fn short(&self) -> &str {
        &self.0[..12]
    }
}

impl TryFrom<String> for Fingerprint {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        Self::parse(&text).ok_or("a key has 64 hexadecimal digits")
    }
}

impl From<Fingerprint> for String {
    fn from(fingerprint: Fingerprint) -> Self {
        fingerprint.0
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Everything that a stage's result depends on, and nothing else: independent of names of arms, paths, times,
/// comments and the spelling of units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// The kind of the stage.
    pub stage: String,
    /// The epoch of the stage's code.
    pub epoch: u32,
    /// The declared fields, resolved, as SI numbers.
    pub fields: Shared<serde_json::Value>,
    /// Contents of other files: the resolved robot, the motion file, the template's digest.
    pub content: Shared<serde_json::Value>,
    /// Fingerprints of the inputs by role.
    pub inputs: BTreeMap<String, Fingerprint>,
    /// Versions of the engines and libraries that numbers depend on.
    pub numeric: Vec<String>,
}

impl Recipe {
    /// The fingerprint.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint_of(&Texts::of(&self.fields, &self.content))
    }

    /// The fingerprint, given the canonical JSON of fields and content.
    pub fn fingerprint_of(&self, texts: &Texts) -> Fingerprint {
        let Texts { fields, content } = texts;
        let inputs = canonical_json(&serde_json::to_value(&self.inputs).expect("fingerprints are texts"));
        let rest = |value: serde_json::Value| canonical_json(&value);
        let (numeric, stage, epoch) =
            (rest(self.numeric.clone().into()), rest(self.stage.clone().into()), self.epoch);
        let mut hasher = blake3::Hasher::new();
        let parts = [
            &format!("{{\"content\":{content},\"epoch\":{epoch},\"fields\":"),
            fields.as_str(),
            &format!(",\"inputs\":{inputs},\"numeric\":{numeric},\"stage\":{stage}}}"),
        ];
        for part in parts {
            hasher.update(part.as_bytes());
        }
        Fingerprint(hasher.finalize().to_hex().to_string())
    }
}

/// Parts of a recipe that many stages share, as canonical JSON.
#[derive(Clone, Debug)]
pub struct Texts {
    /// The fields.
    pub fields: String,
    /// The content.
    pub content: String,
}

impl Texts {
    /// The texts of these parts.
    pub fn of(fields: &serde_json::Value, content: &serde_json::Value) -> Self {
        Self { fields: canonical_json(fields), content: canonical_json(content) }
    }
}

/// JSON with sorted keys, without spaces, and with one form per number (`1`, `1.0` and `1e0` are all `1`;
/// `-0.0` is `0`).
pub fn canonical_json(value: &serde_json::Value) -> String {
    let mut text = String::new();
    write_canonical(value, &mut text);
    text
}

fn write_canonical(value: &serde_json::Value, out: &mut String) {
    use serde_json::Value;
    match value {
        Value::Null | Value::Bool(_) | Value::String(_) => out.push_str(&value.to_string()),
        Value::Number(number) => out.push_str(&canonical_number(number)),
        Value::Array(items) => write_list(out, ['[', ']'], items, write_canonical),
        Value::Object(map) => {
            let sorted: BTreeMap<&String, &Value> = map.iter().collect();
            write_list(out, ['{', '}'], sorted, |(key, item), out| {
                out.push_str(&Value::from(key.as_str()).to_string());
                out.push(':');
                write_canonical(item, out);
            });
        }
    }
}

fn write_list<T>(
    out: &mut String,
    brackets: [char; 2],
    items: impl IntoIterator<Item = T>,
    write: impl Fn(T, &mut String),
) {
    out.push(brackets[0]);
    for (index, item) in items.into_iter().enumerate() {
        if index > 0 {
            out.push(',');
        }
        write(item, out);
    }
    out.push(brackets[1]);
}

/// Whole numbers below 2^53 are written as integers, whatever their type.
fn canonical_number(number: &serde_json::Number) -> String {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match number.as_f64() {
        Some(float) if float.fract() == 0.0 && float.abs() < EXACT => (float as i64).to_string(),
        _ => number.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    #[test]
    fn canonical_json_sorts_keys_and_normalises_numbers() {
        let value = json!({"b": 1.0, "a": [0.1, -0.0, true, null], "c": {"z": "x\"y", "k": 3}});
        assert_eq!(canonical_json(&value), r#"{"a":[0.1,0,true,null],"b":1,"c":{"k":3,"z":"x\"y"}}"#);
    }

    #[test]
    fn a_fingerprint_is_the_hash_of_the_canonical_json_of_the_recipe() {
        let input = Fingerprint("0123456789abcdef".repeat(4));
        let recipe = Recipe {
            stage: "learner".into(),
            epoch: 3,
            fields: json!({"learn": {"seed": 1.0, "name": "x\"y"}}).into(),
            content: json!(null).into(),
            inputs: [("env".to_owned(), input.clone()), ("controller".to_owned(), input)].into(),
            numeric: vec!["libtorch 2.13.0, f32".into()],
        };
        let whole = canonical_json(&serde_json::to_value(&recipe).expect("plain data"));
        assert_eq!(recipe.fingerprint().as_str(), blake3::hash(whole.as_bytes()).to_hex().as_str());
    }

    #[test]
    fn a_fingerprint_is_parsed_only_when_it_is_one() {
        let text = "0123456789abcdef".repeat(4);
        assert_eq!(Fingerprint::parse(&text).expect("64 digits").short(), "0123456789ab");
        assert_eq!(Fingerprint::parse(&text[1..]), None);
        assert_eq!(Fingerprint::parse(&text.replace('a', "A")), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn canonical_json_survives_a_round_trip(numbers in proptest::collection::vec(-1e12f64..1e12, 0..6)) {
            let value = json!({ "numbers": numbers });
            let text = canonical_json(&value);
            let again: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
            prop_assert_eq!(canonical_json(&again), text);
        }
    }
}
