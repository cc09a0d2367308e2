//! The input of the rules.

use crate::diag::{Diagnostic, Span};
use crate::kinds::action::Position;
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::{Evaluation, Setting, Spread};
use crate::kinds::fine_tune::{self, FineTuning};
use crate::kinds::physics::Physics;
use crate::kinds::randomize::Rows;
use crate::kinds::task::Task;
use crate::kinds::terrain::Ground;
use crate::robot::Robot;
use crate::sim::EngineName;
use crate::spec::typed::{InSection, Key, Part, Typed};
use crate::spec::{Marks, Section, Table, Value};
use crate::syntax::Layer;

/// A decoded spec, the places of its values and its robot.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The decoded spec; values that failed are absent.
    pub fields: &'a Table,
    /// The place of each value.
    pub marks: &'a Marks,
    /// The robot, if its file could be read.
    pub robot: Option<&'a Robot>,
}

impl<'a> Subject<'a> {
    /// The value at a dotted path.
    pub fn value(&self, path: &str) -> Option<&'a Value> {
        let mut keys = path.split('.');
        let mut value = self.fields.get(keys.next()?)?;
        for key in keys {
            let Value::Table(table) = value else { return None };
            value = table.get(key)?;
        }
        Some(value)
    }

    /// The number at a dotted path, in SI units.
    pub fn number(&self, path: &str) -> Option<f64> {
        f64::read(self.value(path)?)
    }

    /// The table at a dotted path.
    pub fn section(&self, path: &str) -> Option<Section<'a>> {
        match self.value(path)? {
            Value::Table(table) => Some(Section::new(table)),
            _ => None,
        }
    }

    /// The decoded spec as a section.
    pub fn spec(&self) -> Section<'a> {
        Section::new(self.fields)
    }

    /// A section as its Rust type; `None` if it is absent or invalid.
    pub fn part<P: Part>(&self) -> Option<P> {
        self.spec().part()
    }

    /// The value of a key in its section.
    pub fn at<Owner: InSection, T: Typed>(&self, key: Key<Owner, T>) -> Option<T::Value> {
        self.spec().at(key)
    }

    /// The name of the reference motion; empty if the task has none.
    pub fn motion(&self) -> String {
        Task::named_motion(self.spec()).unwrap_or_default()
    }

    /// The text at a dotted path.
    pub fn text(&self, path: &str) -> Option<&'a str> {
        match self.value(path)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The kind of the term at a path; defaults to its name.
    pub fn kind(&self, path: &str) -> Option<&'a str> {
        self.text(&format!("{path}.kind"))
    }

    /// The terms of a section as paths, `reward.torque`, with their tables.
    pub fn terms<Terms: InSection>(&self) -> Vec<(String, Section<'a>)> {
        self.terms_at(Terms::SECTION)
    }

    /// The same for a table at a path.
    fn terms_at(&self, section: &str) -> Vec<(String, Section<'a>)> {
        let Some(terms) = self.section(section) else { return Vec::new() };
        terms.sections().map(|(name, term)| (format!("{section}.{name}"), term)).collect()
    }

    /// The tables of evaluations and transfers as paths, `evaluate.nominal`, `deploy.mujoco`.
    pub fn protocols(&self) -> Vec<(String, Section<'a>)> {
        [self.terms::<Evaluation>(), self.terms::<Deployment>()].concat()
    }

    /// The tables that run an engine, with its name: training, fine-tuning, evaluations, transfers.
    pub fn tables_with_engines(&self) -> Vec<(String, EngineName)> {
        let trained = self.at(Physics::engine);
        let tuned = self.spec().within::<FineTuning>().map(|table| (FineTuning::SECTION.to_owned(), table));
        let others = tuned.into_iter().chain(self.protocols());
        let engine = |table: Section| table.value(Setting::engine).or(trained);
        let others = others.filter_map(|(path, table)| Some((path, engine(table)?)));
        let training = trained.map(|engine| (Physics::SECTION.to_owned(), engine));
        training.into_iter().chain(others).collect()
    }

    /// The paths of all terrains: `terrain`, that of the fine-tuning, and those of evaluations.
    pub fn grounds(&self) -> Vec<String> {
        let own = self.protocols().into_iter().map(|(path, _)| Setting::terrain.below(&path));
        [Ground::SECTION.to_owned(), fine_tune::Ppo::terrain.path()]
            .into_iter()
            .chain(own)
            .filter(|path| self.section(path).is_some())
            .collect()
    }

    /// All randomization terms: of `randomize` and of evaluations.
    pub fn randomizations(&self) -> Vec<(String, Section<'a>)> {
        let own = self.protocols().into_iter().map(|(path, _)| Spread::randomize.below(&path));
        std::iter::once(Rows::SECTION.to_owned()).chain(own).flat_map(|path| self.terms_at(&path)).collect()
    }

    /// The number at a path as written, otherwise in SI units.
    pub fn written(&self, path: &str) -> String {
        match self.value(path) {
            Some(Value::Quantity(quantity)) if !quantity.text.is_empty() => quantity.text.clone(),
            Some(Value::Count(count)) => count.to_string(),
            Some(Value::Text(text)) => text.clone(),
            _ => String::new(),
        }
    }

    /// The diagnostic with an edit that replaces the value at a path by `replacement` (TOML). Defaults have
    /// no place to edit.
    pub fn edited(&self, path: &str, replacement: impl Into<String>, diagnostic: Diagnostic) -> Diagnostic {
        match self.marks.get(path).filter(|mark| mark.layer != Layer::Default) {
            Some(mark) => diagnostic.fix(mark.value, replacement),
            None => diagnostic,
        }
    }

    /// The place of the value at a path, or of the table that contains it.
    pub fn place(&self, path: &str) -> Option<Span> {
        self.marks.nearest(path).map(|mark| mark.value)
    }

    /// Duration of a physics step in s.
    pub fn physics_step(&self) -> Option<f64> {
        self.at(Physics::rate).filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate)
    }

    /// Duration of a control step in s.
    pub fn control_step(&self) -> Option<f64> {
        self.at(Position::rate).filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate)
    }
}

/// The nearest whole number, if the number is whole up to rounding.
pub(super) fn whole(number: f64) -> Option<f64> {
    let nearest = number.round();
    ((number - nearest).abs() <= 1e-6 * nearest.abs().max(1.0)).then_some(nearest)
}

/// A number with at most four significant digits and no trailing zeros: `166.7`, `0.125`, `12000`,
/// `1.000e300`.
pub(super) fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    if number.abs() >= 1e15 || number.abs() < 1e-9 {
        return format!("{number:.3e}");
    }
    let digits = 3 - libm::floor(libm::log10(number.abs())) as i32;
    let text = format!("{number:.*}", digits.clamp(0, 12) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A duration in a suitable unit, to the nanosecond.
pub(super) fn duration(seconds: f64) -> String {
    let exact = |value: f64| ((value * 1e6).round() / 1e6).to_string();
    if seconds != 0.0 && seconds.abs() < 1.0 {
        format!("{} ms", exact(seconds * 1e3))
    } else {
        format!("{} s", ((seconds * 1e9).round() / 1e9))
    }
}

#[cfg(test)]
pub(super) mod sample {
    use super::*;
    use crate::diag::{Diagnostic, Sink};
    use crate::spec::{Quantity, Sampler};

    /// A table from TOML for the tests of the rules: numbers are SI, `[a, b]` is a uniform distribution.
    pub fn table(text: &str) -> Table {
        let parsed: toml::Table = toml::from_str(text).expect("the test's TOML is valid");
        parsed.into_iter().map(|(key, value)| (key, decoded(value))).collect()
    }

    fn decoded(value: toml::Value) -> Value {
        match value {
            toml::Value::Boolean(flag) => Value::Flag(flag),
            toml::Value::Integer(count) => Value::Count(count as u64),
            toml::Value::Float(si) => Value::Quantity(Quantity { si, text: short(si) }),
            toml::Value::String(text) => Value::Text(text),
            toml::Value::Array(items) => match items.as_slice() {
                [toml::Value::Float(low), toml::Value::Float(high)] => {
                    Value::Sampler(Sampler::Uniform([*low, *high]))
                }
                _ => Value::List(items.into_iter().map(decoded).collect()),
            },
            toml::Value::Table(table) => {
                Value::Table(table.into_iter().map(|(key, value)| (key, decoded(value))).collect())
            }
            toml::Value::Datetime(time) => Value::Text(time.to_string()),
        }
    }

    /// The diagnostics of a rule for a spec.
    pub fn found(rule: fn(&Subject, &mut Sink), text: &str, robot: Option<&Robot>) -> Vec<Diagnostic> {
        let mut sink = Sink::default();
        rule(&Subject { fields: &table(text), marks: &Marks::default(), robot }, &mut sink);
        sink.diagnostics
    }

    /// Asserts that a rule is silent about TOCABI and a text with each sound value in place of its `{}`, and
    /// that each odd one gives a single W0523 with these words.
    pub fn values(rule: fn(&Subject, &mut Sink), text: &str, sound: &[&str], odd: &[(&str, &str)]) {
        let tocabi = crate::robot::tests::robot("tocabi");
        let told = |value: &str| {
            let found = found(rule, &text.replace("{}", value), Some(&tocabi));
            assert!(found.iter().all(|found| found.code == "W0523"), "{found:?}");
            found.into_iter().map(|found| found.message).collect::<Vec<_>>()
        };
        for value in sound {
            assert_eq!(told(value), [""; 0], "{value}");
        }
        for (value, words) in odd {
            let told = told(value);
            assert!(told.len() == 1 && told[0].contains(words), "{value}: {told:?}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_have_four_digits() {
        assert_eq!(short(166.666_666), "166.7");
        assert_eq!(short(500.0), "500");
        assert_eq!(short(0.125), "0.125");
        assert_eq!(short(-1e300), "-1.000e300");
        assert_eq!(short(5e-324), "4.941e-324");
        assert_eq!(short(12_345.6), "12346");
        assert_eq!(duration(0.0015), "1.5 ms");
        assert_eq!(duration(16.0), "16 s");
        assert_eq!(duration(16.004), "16.004 s");
    }
}
