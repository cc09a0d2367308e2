//! Bounds of keys and validity of distributions: the same rules for values decoded from a spec and for values
//! read from a policy file.

use super::{Param, Sampler, Ty, Value};
use crate::quantity::{self, Dimension};

/// What is wrong with a distribution, independent of the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// The lower end of its range is above the upper.
    Swapped,
    /// Its standard deviation is negative.
    NegativeDeviation,
    /// Its list of choices is empty.
    NoChoice,
    /// It is log-uniform, and its lower end is not above zero.
    NotPositive,
}

/// The first problem of a distribution, if any.
pub fn flaw(sampler: &Sampler) -> Option<Flaw> {
    match sampler {
        Sampler::Uniform([low, high]) | Sampler::LogUniform([low, high]) if low > high => Some(Flaw::Swapped),
        Sampler::Normal([_, std]) if *std < 0.0 => Some(Flaw::NegativeDeviation),
        Sampler::Choice(values) if values.is_empty() => Some(Flaw::NoChoice),
        Sampler::LogUniform([low, _]) if *low <= 0.0 => Some(Flaw::NotPositive),
        _ => None,
    }
}

/// The interval of a distribution's draws that is compared with bounds.
pub fn reach(sampler: &Sampler) -> [f64; 2] {
    let is_normal = matches!(sampler, Sampler::Normal(_));
    // Rounded to 1e-12, so that 0.3 - 3 * 0.1 is not less than 0.
    sampler
        .bounds()
        .map(|bound| if is_normal && bound.abs() < 1e3 { (bound * 1e12).round() / 1e12 } else { bound })
}

/// Whether a number is within the bounds of a key.
pub fn holds(param: &Param, si: f64) -> bool {
    param.range.is_none_or(|(low, high)| low <= si && si <= high)
}

/// The bounds of a key as text, `between 0 m and 1 m`; empty for a key without bounds.
pub fn in_words(param: &Param, dimension: Dimension) -> String {
    let print = |bound: f64| match param.ty {
        Ty::Ratio(_) => quantity::print_ratio(bound),
        _ => quantity::print(bound, dimension),
    };
    param.range.map(|(low, high)| format!("between {} and {}", print(low), print(high))).unwrap_or_default()
}

/// What is wrong with a decoded number, distribution or list of a key, `1e300 is not between -10 and 10 (in
/// SI units)`. Of tables only those with user-defined names are checked: the others have keys of their own.
pub fn violation(param: &Param, value: &Value) -> Option<String> {
    let number = |si: f64| {
        let bounds = in_words(param, Dimension::NONE);
        (!si.is_finite() || !holds(param, si))
            .then(|| format!("is {}, not {bounds} in SI units", quantity::number(si)))
            .map(|text| if bounds.is_empty() { "is not finite".to_owned() } else { text })
    };
    match value {
        Value::Quantity(quantity) => {
            number(quantity.si).or_else(|| (is_scale(param) && quantity.si <= 0.0).then(not_positive))
        }
        Value::Count(count) => number(*count as f64),
        Value::Sampler(sampler) => match flaw(sampler) {
            Some(_) => Some("is not a distribution".to_owned()),
            None => {
                let bounds = reach(sampler);
                let broken = bounds.into_iter().find_map(number);
                broken.or_else(|| (is_scale(param) && bounds[0] <= 0.0).then(not_positive))
            }
        },
        Value::List(items) => items.iter().find_map(|item| violation(param, item)),
        Value::Table(table) if matches!(param.ty, Ty::Named(_)) => {
            table.values().find_map(|item| violation(param, item))
        }
        Value::Flag(_) | Value::Text(_) | Value::Table(_) => None,
    }
}

/// Whether a key scales a physical quantity, so that it must be positive.
pub fn is_scale(param: &Param) -> bool {
    param.name == "scale" && matches!(param.ty, Ty::Sampler(_))
}

fn not_positive() -> String {
    "is a scale that is not positive".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Quantity;

    const SPEED: Param = Param::required("speed", Ty::Sampler(Dimension::VELOCITY)).range(-10.0, 10.0);

    fn si(si: f64) -> Value {
        Value::Quantity(Quantity { si, text: String::new() })
    }

    #[test]
    fn numbers_lists_and_distributions_are_held_to_the_same_bounds() {
        assert_eq!(violation(&SPEED, &si(10.0)), None);
        let said = violation(&SPEED, &si(1e300)).expect("it is too fast");
        assert_eq!(said, "is 1e300, not between -10 and 10 in SI units");
        for value in [
            Value::List(vec![si(1.0), si(-11.0)]),
            Value::Sampler(Sampler::Uniform([-1e308, 1e308])),
            Value::Sampler(Sampler::Normal([0.0, 4.0])),
            Value::Sampler(Sampler::Uniform([2.0, 1.0])),
            Value::Sampler(Sampler::Choice(Vec::new())),
            si(f64::NAN),
        ] {
            assert!(violation(&SPEED, &value).is_some(), "{value:?}");
        }
        assert_eq!(violation(&SPEED, &Value::Sampler(Sampler::Normal([0.0, 3.0]))), None);
    }

    #[test]
    fn a_key_without_bounds_takes_every_finite_number() {
        let free = Param::required("seed", Ty::Count);
        assert_eq!(violation(&free, &Value::Count(u64::MAX)), None);
        assert_eq!(violation(&free, &si(f64::INFINITY)).as_deref(), Some("is not finite"));
    }
}
