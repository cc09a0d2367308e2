//! Quantities relative to a robot: `"0.16 mgh/rad"`.
//!
//! `m` is the robot's mass, `g` the acceleration of gravity and `h` the height of its pelvis, so `mgh` is the
//! torque that holds the robot's weight at that height. The same number therefore means the same softness, the
//! same damping and the same strength of exploration for robots of any size
//! (`docs/experiments/2026-11-25-figures-for-the-weight.md`). Independent of robots: what a number amounts to
//! on one of them is computed elsewhere.

use super::QuantityError;
use super::parse::{leading_blanks, number_range, scaled};

/// The word that marks such a quantity.
pub const WORD: &str = "mgh";

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A torque, in m g h.
    Torque,
    /// A joint stiffness, in m g h per rad.
    Stiffness,
    /// A joint damping, in m g h per rad times sqrt(h / g).
    Damping,
}

impl Measure {
    /// Every measure.
    pub const ALL: [Self; 3] = [Self::Torque, Self::Stiffness, Self::Damping];

    /// The unit as a spec writes it.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Torque => "mgh",
            Self::Stiffness => "mgh/rad",
            Self::Damping => "mgh*sqrt(h/g)/rad",
        }
    }

    /// The user's term, with an article.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Torque => "a torque relative to the robot",
            Self::Stiffness => "a stiffness relative to the robot",
            Self::Damping => "a damping relative to the robot",
        }
    }

    /// A quantity of about the usual size.
    pub const fn example(self) -> &'static str {
        match self {
            Self::Torque => "1.7 % mgh",
            Self::Stiffness => "0.16 mgh/rad",
            Self::Damping => "0.023 mgh*sqrt(h/g)/rad",
        }
    }
}

/// A quantity relative to a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// In its unit; 0.017 for `1.7 % mgh`.
    pub number: f64,
    /// What it measures.
    pub measure: Measure,
}

/// Parses a quantity relative to a robot: a number, an optional `%`, and a unit. `None` for a text without
/// `mgh`.
pub fn relative(text: &str) -> Option<Result<Relative, QuantityError>> {
    text.contains(WORD).then(|| parse(text))
}

fn parse(text: &str) -> Result<Relative, QuantityError> {
    let number = number_range(text)?;
    let start = number.end + leading_blanks(&text[number.end..]);
    let rest = text[start..].trim_end();
    let (exponent, unit) = rest.strip_prefix('%').map_or((0, rest), |unit| (-2, unit));
    let compact: String = unit.chars().filter(|letter| !letter.is_whitespace()).collect();
    let Some(measure) = Measure::ALL.into_iter().find(|measure| measure.unit() == compact) else {
        let range =
            text.len() - text[start..].len() + (rest.len() - unit.trim_start().len())..start + rest.len();
        return Err(QuantityError::UnknownUnit {
            found: text[range.clone()].to_owned(),
            range,
            suggestion: None,
        });
    };
    match scaled(&text[number.clone()], exponent).filter(|value| value.is_finite()) {
        Some(number) => Ok(Relative { number, measure }),
        None => Err(QuantityError::NotFinite { number }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measure_reads_its_own_unit_with_and_without_a_percent_sign() {
        for measure in Measure::ALL {
            let unit = measure.unit();
            assert_eq!(relative(&format!("0.5 {unit}")), Some(Ok(Relative { number: 0.5, measure })));
            assert_eq!(relative(&format!(" 50 % {unit} ")), Some(Ok(Relative { number: 0.5, measure })));
            assert!(matches!(relative(measure.example()), Some(Ok(read)) if read.measure == measure));
        }
        assert_eq!(relative("1.7%mgh"), Some(Ok(Relative { number: 0.017, measure: Measure::Torque })));
        assert_eq!(
            relative("1 mgh / rad").and_then(Result::ok).map(|read| read.measure),
            Some(Measure::Stiffness)
        );
        assert_eq!(relative("10 %"), None);
    }

    #[test]
    fn another_combination_of_units_names_its_place() {
        let found = |text: &str| match relative(text) {
            Some(Err(QuantityError::UnknownUnit { range, found, .. })) => (text[range].to_owned(), found),
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(found("0.16 mgh/deg"), ("mgh/deg".into(), "mgh/deg".into()));
        assert_eq!(found("16 % mgh*s"), ("mgh*s".into(), "mgh*s".into()));
        assert!(matches!(relative("1e999 mgh"), Some(Err(QuantityError::NotFinite { .. }))));
        assert!(matches!(relative("mgh"), Some(Err(QuantityError::NoNumber { .. }))));
    }
}
