//! Decoded values, which the rest of the program uses.
//!
//! All numbers are SI. A quantity stores its original text for printing; fingerprints use only the number
//! ([`Value::canonical`]), so `"4 ms"` and `"0.004 s"` are one value.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::quantity;

/// A table of decoded values by key.
pub type Table = BTreeMap<String, Value>;

/// A decoded value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Value {
    /// `true` or `false`.
    Flag(bool),
    /// A whole number.
    Count(u64),
    /// A number in SI units, with its original text.
    Quantity(Quantity),
    /// A word or a text.
    Text(String),
    /// A list.
    List(Vec<Value>),
    /// A distribution.
    Sampler(Sampler),
    /// A table.
    Table(Table),
}

/// A number in SI units and its original text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The value in SI units; a ratio is 1.0 at 100 %.
    pub si: f64,
    /// The original text, for example `4 ms`, `10 %` or `0.3`. Of a quantity relative to the robot both, with
    /// the share that it amounts to: `0.16 mgh/rad = 4.523 %`.
    pub text: String,
}

impl Quantity {
    /// What separates the original text of a quantity relative to the robot from its share.
    pub const EQUALS: &str = " = ";

    /// The share that a quantity relative to the robot amounts to, as text; `None` for any other.
    pub fn share(&self) -> Option<&str> {
        self.text.rsplit_once(Self::EQUALS).map(|(_, share)| share)
    }

    /// Whether parsing the text gives the number.
    pub fn says_its_number(&self) -> bool {
        self.reading() == Some(true)
    }

    /// Whether parsing the text gives another number. False if it cannot be parsed.
    pub fn denies_its_number(&self) -> bool {
        self.reading() == Some(false)
    }

    fn reading(&self) -> Option<bool> {
        let text = self.share().unwrap_or(&self.text);
        let bare = || text.replace('_', "").parse().ok();
        let read: f64 = quantity::quantity(text).ok().map(|parsed| parsed.si).or_else(bare)?;
        // A number that was computed and then printed may differ in its last digits.
        Some((read - self.si).abs() <= 1e-9 * self.si.abs())
    }
}

/// A distribution over numbers in SI units: the sampler type of noise, randomization, commands and initial
/// states. Users of [`crate::spec::value::Sampler`] draw from it with their own named random streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    /// Always this value.
    Constant(f64),
    /// Uniform over `[low, high]`.
    Uniform([f64; 2]),
    /// Normal with `[mean, standard deviation]`.
    Normal([f64; 2]),
    /// Log-uniform over `[low, high]`.
    LogUniform([f64; 2]),
    /// One of these, with equal probability.
    Choice(Vec<f64>),
}

impl Sampler {
    /// The words for distributions.
    pub const WORDS: &[&str] = &["choice", "log_uniform", "normal", "uniform"];

    /// The interval of all draws; three standard deviations for a normal distribution.
    pub fn bounds(&self) -> [f64; 2] {
        match self {
            Self::Constant(value) => [*value, *value],
            Self::Uniform(bounds) | Self::LogUniform(bounds) => *bounds,
            Self::Normal([mean, std]) => [mean - 3.0 * std, mean + 3.0 * std],
            Self::Choice(values) => [
                values.iter().copied().fold(f64::INFINITY, f64::min),
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ],
        }
    }

    /// A draw, given two uniform numbers in `[0, 1)`. Only the normal distribution uses the second.
    pub fn draw(&self, first: f64, second: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Uniform([low, high]) => low + (high - low) * first,
            Self::LogUniform([low, high]) => low * libm::exp(first * libm::log(high / low)),
            Self::Normal([mean, std]) => {
                let radius = libm::sqrt(-2.0 * libm::log(1.0 - first));
                mean + std * radius * libm::cos(std::f64::consts::TAU * second)
            }
            Self::Choice(values) => {
                let index = (first * values.len() as f64) as usize;
                values[index.min(values.len() - 1)]
            }
        }
    }
}

impl Value {
    /// The string of a text.
    pub fn as_text(&self) -> Option<&String> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The entries of a table.
    pub fn as_table(&self) -> Option<&Table> {
        match self {
            Self::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The table to be changed, if it is one.
    pub fn as_table_mut(&mut self) -> Option<&mut Table> {
        match self {
            Self::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The value as canonical JSON: SI numbers, no text, keys sorted. Equal values have equal canonical JSON.
    pub fn canonical(&self) -> serde_json::Value {
        use serde_json::json;
        match self {
            Self::Flag(flag) => json!(flag),
            Self::Count(count) => json!(count),
            Self::Quantity(quantity) => json!(quantity.si),
            Self::Text(text) => json!(text),
            Self::List(items) => items.iter().map(Self::canonical).collect(),
            Self::Sampler(Sampler::Constant(value)) => json!(value),
            Self::Sampler(sampler) => json!(sampler),
            Self::Table(table) => canonical_table(table),
        }
    }
}

/// A table as canonical JSON, keys sorted.
pub fn canonical_table(table: &Table) -> serde_json::Value {
    serde_json::Value::Object(table.iter().map(|(key, value)| (key.clone(), value.canonical())).collect())
}

/// The key with the kind of a table, which decoding always fills in.
pub const KIND: &str = "kind";

/// A view of one decoded table.
///
/// Keys are read through their declarations: see [`crate::spec::typed`].
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    table: &'a Table,
}

impl<'a> Section<'a> {
    /// A view of the table.
    pub fn new(table: &'a Table) -> Self {
        Self { table }
    }

    /// The table itself.
    pub fn table(&self) -> &'a Table {
        self.table
    }

    /// The kind of the table, filled in by decoding.
    pub fn kind(&self) -> Option<&'a str> {
        self.get(KIND)?.as_text().map(String::as_str)
    }

    /// The value of an optional key.
    pub fn get(&self, key: &str) -> Option<&'a Value> {
        self.table.get(key)
    }

    /// The table of this key, if present.
    pub fn section(&self, key: &str) -> Option<Section<'a>> {
        match self.get(key) {
            Some(Value::Table(table)) => Some(Section { table }),
            _ => None,
        }
    }

    /// The tables below this one, in key order: the terms of a section such as `reward`.
    pub fn sections(&self) -> impl Iterator<Item = (&'a str, Section<'a>)> + use<'a> {
        self.table.iter().filter_map(|(key, value)| match value {
            Value::Table(table) => Some((key.as_str(), Section { table })),
            _ => None,
        })
    }
}

/// The number of a scalar value, in SI units.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Quantity(quantity) => Some(quantity.si),
        Value::Count(count) => Some(*count as f64),
        Value::Sampler(Sampler::Constant(value)) => Some(*value),
        _ => None,
    }
}
