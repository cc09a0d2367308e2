//! Text to a number in SI units: `"4 /rad^2"`, `"0.01 /N/m"`, `"20 s^2/m^2"`, `"80 M"`.
//!
//! Errors have byte ranges of the text; the caller adds their position in the file.

use std::ops::Range;

use super::{Dimension, unit};

/// A number with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parsed {
    /// The value in SI units.
    pub si: f64,
    /// Its dimension.
    pub dimension: Dimension,
}

/// What is wrong with a quantity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// The text does not begin with a number (E0103).
    #[error("`{text}` does not begin with a number")]
    NoNumber {
        /// The text.
        text: String,
    },
    /// The unit is missing (E0201).
    #[error("the unit is missing")]
    UnitMissing {
        /// Range of the number.
        number: Range<usize>,
    },
    /// An unknown unit, or units that are combined wrongly (E0202).
    #[error("unknown unit `{found}`")]
    UnknownUnit {
        /// Range of the word.
        range: Range<usize>,
        /// The word.
        found: String,
        /// The probably intended unit, as its replacement.
        suggestion: Option<String>,
    },
    /// The unit has another dimension (E0203).
    #[error("expected {}, found {}", expected.name(), found.name())]
    Mismatch {
        /// Range of the unit.
        range: Range<usize>,
        /// Its dimension.
        found: Dimension,
        /// The required dimension.
        expected: Dimension,
    },
    /// Infinite, NaN, or too large (E0205).
    #[error("the number is not finite")]
    NotFinite {
        /// Range of the number.
        number: Range<usize>,
    },
}

/// Parses a quantity of any dimension. A number without a unit is an error, because quantities are written as
/// strings only for their unit.
pub fn quantity(text: &str) -> Result<Parsed, QuantityError> {
    let number = number_range(text)?;
    let rest = number.end + leading_blanks(&text[number.end..]);
    let unit_text = text[rest..].trim_end();
    if !text[number.clone()].bytes().any(|byte| byte.is_ascii_digit()) {
        return Err(QuantityError::NotFinite { number });
    }
    if unit_text.is_empty() {
        return Err(QuantityError::UnitMissing { number });
    }
    let (dimension, exponent, factor) = units(unit_text, rest)?;
    let si = scaled(&text[number.clone()], exponent).map(|value| value * factor);
    match si.filter(|value| value.is_finite()) {
        Some(si) => Ok(Parsed { si, dimension }),
        None => Err(QuantityError::NotFinite { number }),
    }
}

/// Parses a quantity of this dimension and returns it in SI units. Units of other dimensions are not
/// suggested.
pub fn quantity_of(text: &str, expected: Dimension) -> Result<f64, QuantityError> {
    let parsed = quantity(text).map_err(|error| match error {
        QuantityError::UnknownUnit { range, found, suggestion } => {
            let suggestion = suggestion.filter(|unit| {
                let mut cured = text.to_owned();
                cured.replace_range(range.clone(), unit);
                quantity(&cured).map_or(true, |parsed| parsed.dimension == expected)
            });
            QuantityError::UnknownUnit { range, found, suggestion }
        }
        error => error,
    })?;
    if parsed.dimension == expected {
        return Ok(parsed.si);
    }
    Err(QuantityError::Mismatch { range: unit_range(text), found: parsed.dimension, expected })
}

/// Errors of a count.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CountError {
    /// The number is missing or has a fraction (E0103).
    #[error("it is not a whole number")]
    NotWhole,
    /// It is negative or too large (E0204).
    #[error("{0} is not a valid count")]
    OutOfRange(f64),
    /// An unknown count suffix (E0202).
    #[error("unknown count suffix `{0}`")]
    Suffix(String),
}

/// Largest count: above it, not every whole number is an `f64`.
pub const MOST_COUNTED: u64 = 1 << 53;

/// The power of ten of a count suffix.
fn suffix(word: &str) -> Option<i32> {
    match word {
        "k" => Some(3),
        "M" => Some(6),
        "G" => Some(9),
        _ => None,
    }
}

/// Parses a number with a count suffix, which may be negative or a fraction: `-200 k`, `1.5 M`. `None` for
/// every other text.
pub fn counted(text: &str) -> Option<f64> {
    let number = number_range(text).ok()?;
    let exponent = suffix(text[number.end..].trim())?;
    scaled(&text[number], exponent).filter(|value| value.is_finite())
}

/// Parses a count: `16384`, `"200 k"`, `"80 M"`.
pub fn count(text: &str) -> Result<u64, CountError> {
    let number = number_range(text).map_err(|_| CountError::NotWhole)?;
    let exponent = match text[number.end..].trim() {
        "" => 0,
        word => suffix(word).ok_or_else(|| CountError::Suffix(word.to_owned()))?,
    };
    let value = scaled(&text[number], exponent).ok_or(CountError::NotWhole)?;
    if value < 0.0 || value > MOST_COUNTED as f64 {
        return Err(CountError::OutOfRange(value));
    }
    if value.fract() == 0.0 { Ok(value as u64) } else { Err(CountError::NotWhole) }
}

/// Whether the text begins like a quantity: with a sign, a point or a digit.
pub fn looks_like_quantity(text: &str) -> bool {
    text.trim_start().starts_with(|first: char| first.is_ascii_digit() || matches!(first, '+' | '-' | '.'))
}

/// Range of a quantity's unit in its text.
fn unit_range(text: &str) -> Range<usize> {
    let start = number_range(text).map_or(0, |number| number.end);
    start + leading_blanks(&text[start..])..text.trim_end().len()
}

pub(super) fn leading_blanks(text: &str) -> usize {
    text.len() - text.trim_start().len()
}

/// The number at the beginning of a text. Words such as `inf` and `nan` count as numbers.
pub(super) fn number_range(text: &str) -> Result<Range<usize>, QuantityError> {
    let start = leading_blanks(text);
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while at < bytes.len() && (bytes[at].is_ascii_digit() || bytes[at] == b'_') {
            at += 1;
        }
        at
    };
    let mut at = start;
    if matches!(bytes.get(at), Some(b'+' | b'-')) {
        at += 1;
    }
    if let Some(word) = ["inf", "nan"].iter().find(|word| text[at..].starts_with(**word)) {
        return Ok(start..at + word.len());
    }
    let whole = digits(at);
    let mut end = whole;
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if end == at || &text[at..end] == "." {
        return Err(QuantityError::NoNumber { text: text.to_owned() });
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    Ok(start..end)
}

/// A decimal number times a power of ten, rounded once.
pub(super) fn scaled(number: &str, exponent: i32) -> Option<f64> {
    let number = number.replace('_', "");
    let (mantissa, written) = match number.split_once(['e', 'E']) {
        Some((mantissa, written)) => (mantissa, written.parse::<i32>().ok()?),
        None => (number.as_str(), 0),
    };
    match written.checked_add(exponent)? {
        0 => mantissa.parse().ok(),
        exponent => format!("{mantissa}e{exponent}").parse().ok(),
    }
}

/// Parses the units, which begin at `start` of the whole text.
fn units(text: &str, start: usize) -> Result<(Dimension, i32, f64), QuantityError> {
    let unknown = |range: Range<usize>, suggestion: Option<String>| QuantityError::UnknownUnit {
        found: text[range.clone()].to_owned(),
        range: start + range.start..start + range.end,
        suggestion,
    };
    let (mut dimension, mut exponent, mut factor) = (Dimension::NONE, 0, 1.0);
    let mut at = 0;
    let mut sign = 1;
    if text.starts_with('/') {
        sign = -1;
        at = 1;
    }
    loop {
        let end = text[at..].find(['*', '/']).map_or(text.len(), |offset| at + offset);
        let begin = at + leading_blanks(&text[at..end]);
        let word = text[at..end].trim();
        let range = begin..begin + word.len();
        if word.is_empty() {
            return Err(unknown(0..text.len(), None));
        }
        let (symbol, power) = match word.split_once('^') {
            None => (word, 1),
            Some((symbol, power)) => match power.parse::<i8>() {
                Ok(power) if (-9..=9).contains(&power) && power != 0 => (symbol, power),
                _ => return Err(unknown(range, None)),
            },
        };
        let Some(found) = unit::find(symbol) else {
            return Err(unknown(range, suggestion(symbol, word, sign)));
        };
        let power = sign * power;
        dimension = dimension.times(found.dimension, power).ok_or_else(|| unknown(range, None))?;
        exponent += found.exponent * i32::from(power);
        for _ in 0..power.unsigned_abs() {
            factor = if power > 0 { factor * found.factor } else { factor / found.factor };
        }
        if end == text.len() {
            return Ok((dimension, exponent, factor));
        }
        sign = if text.as_bytes()[end] == b'/' { -1 } else { 1 };
        at = end + 1;
    }
}

/// A replacement for an unknown word: `N*m` for `N m`, `N/m` after a `/`, `s` for `sec`.
fn suggestion(symbol: &str, word: &str, sign: i8) -> Option<String> {
    let parts: Vec<&str> = word.split_whitespace().collect();
    let known = |part: &&str| unit::find(part.split('^').next().unwrap_or(part)).is_some();
    if parts.len() > 1 && parts.iter().all(known) {
        return Some(parts.join(if sign < 0 { "/" } else { "*" }));
    }
    for (superscript, power) in [("²", "^2"), ("³", "^3")] {
        if let Some(unit) = word.strip_suffix(superscript) {
            return Some(format!("{unit}{power}"));
        }
    }
    unit::suggest(symbol).map(|unit| word.replacen(symbol, &unit, 1))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::quantity::print;

    fn si(text: &str, dimension: Dimension) -> f64 {
        quantity_of(text, dimension).unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn quantities_of_the_language_page_are_read_in_si() {
        assert_eq!(si("500 Hz", Dimension::RATE), 500.0);
        assert_eq!(si("4 ms", Dimension::TIME), 0.004);
        assert_eq!(si("3 ms", Dimension::TIME), 0.003);
        assert_eq!(si("1e-4 rad", Dimension::ANGLE), 1e-4);
        assert_eq!(si("13.2 /rad", Dimension::PER_ANGLE), 13.2);
        assert_eq!(si("4 /rad^2", Dimension::PER_ANGLE_SQUARED), 4.0);
        assert_eq!(si("3 s^2/m^2", Dimension::PER_VELOCITY_SQUARED), 3.0);
        assert_eq!(si("0.01 s^2/rad^2", Dimension::PER_ANGULAR_VELOCITY_SQUARED), 0.01);
        assert_eq!(si("0.0005 /N", Dimension::PER_FORCE), 0.0005);
        assert_eq!(si("0.01 /N/m", Dimension::PER_TORQUE), 0.01);
        assert_eq!(si("10 %", Dimension::NONE), 0.1);
        assert_eq!(si("12.5 %", Dimension::NONE), 0.125);
        assert_eq!(si("62.69512 kg", Dimension::MASS), 62.69512);
        assert_eq!(si("0.5 kg*m^2", Dimension::INERTIA), 0.5);
        assert_eq!(si("180 deg", Dimension::ANGLE), std::f64::consts::PI);
        assert_eq!(si("60 rpm", Dimension::ANGULAR_VELOCITY), std::f64::consts::TAU);
        assert_eq!(si("1.5 min", Dimension::TIME), 90.0);
        assert_eq!(si("2 h", Dimension::TIME), 7200.0);
        assert_eq!(si("36 km/h", Dimension::VELOCITY), 10.0);
        assert_eq!(si("1 V*A", Dimension::new(2, 1, -3, 0, 0)), 1.0);
        assert_eq!(si("-0.6m", Dimension::LENGTH), -0.6);
    }

    #[test]
    fn a_hertz_is_not_an_angular_velocity() {
        let error = quantity_of("5 Hz", Dimension::ANGULAR_VELOCITY).expect_err("different dimensions");
        assert_eq!(error.to_string(), "expected an angular velocity, found a rate");
        let error = quantity_of("0.8 rad/s", Dimension::ANGLE).expect_err("different dimensions");
        let QuantityError::Mismatch { range, .. } = error else { panic!("{error}") };
        assert_eq!(range, 4..9);
    }

    #[test]
    fn mistakes_are_told_apart_and_placed() {
        assert_eq!(quantity("0.05"), Err(QuantityError::UnitMissing { number: 0..4 }));
        assert_eq!(quantity("1e999 s"), Err(QuantityError::NotFinite { number: 0..5 }));
        assert_eq!(quantity("inf s"), Err(QuantityError::NotFinite { number: 0..3 }));
        assert!(matches!(quantity("fast"), Err(QuantityError::NoNumber { .. })));
        let unknown = |range, found: &str, suggestion: Option<&str>| {
            Err(QuantityError::UnknownUnit {
                range,
                found: found.to_owned(),
                suggestion: suggestion.map(str::to_owned),
            })
        };
        assert_eq!(quantity("4 sec"), unknown(2..5, "sec", Some("s")));
        assert_eq!(quantity("1 N m"), unknown(2..5, "N m", Some("N*m")));
        assert_eq!(quantity("1 /N m"), unknown(3..6, "N m", Some("N/m")));
        assert_eq!(quantity("1 s²/m"), unknown(2..5, "s²", Some("s^2")));
        assert_eq!(quantity("1 N*/m"), unknown(2..6, "N*/m", None));
        assert_eq!(quantity("1 m^x"), unknown(2..5, "m^x", None));
        assert_eq!(quantity("1 sec^2/m"), unknown(2..7, "sec^2", Some("s^2")));
        let torque = |expected| quantity_of("10 Nm", expected).map(|si| Parsed { si, dimension: expected });
        assert_eq!(torque(Dimension::TORQUE), unknown(3..5, "Nm", Some("N*m")));
        assert_eq!(
            torque(Dimension::NONE),
            unknown(3..5, "Nm", None),
            "it would be a torque where a share is asked for"
        );
    }

    #[test]
    fn counts_take_k_and_m() {
        assert_eq!(count("80 M"), Ok(80_000_000));
        assert_eq!(count("200 k"), Ok(200_000));
        assert_eq!(count("1.5M"), Ok(1_500_000));
        assert_eq!(count("16384"), Ok(16384));
        assert_eq!(count("0.5"), Err(CountError::NotWhole));
        assert_eq!(count("1.23456789 M"), Err(CountError::NotWhole));
        assert_eq!(count("-1 M"), Err(CountError::OutOfRange(-1e6)));
        assert_eq!(count("99999999999 M"), Err(CountError::OutOfRange(99_999_999_999e6)));
        assert_eq!(count("3 m"), Err(CountError::Suffix("m".to_owned())));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn what_is_printed_is_read_again(
            value in -1e9f64..1e9, length in -3i8..4, mass in -3i8..4, time in -3i8..4, angle in -3i8..4,
            current in -3i8..4,
        ) {
            let dimension = Dimension::new(length, mass, time, current, angle);
            prop_assume!(dimension != Dimension::NONE);
            let text = print(value, dimension);
            prop_assert_eq!(quantity(&text), Ok(Parsed { si: value, dimension }), "{}", text);
        }

        #[test]
        fn no_text_makes_the_parser_fail_otherwise_than_by_an_error(text in "[-+0-9.e a-zA-Zµ²%*/^]{0,16}") {
            let _ = quantity(&text);
            let _ = count(&text);
        }
    }
}
