//! Physical quantities of the spec language: dimensions, units, parsing and printing.
//!
//! Inside the program every number is SI and its name has no unit; units occur only in specs and messages.
//! Independent of TOML.

pub mod dimension;
pub mod parse;
pub mod relative;
pub mod unit;

pub use dimension::Dimension;
pub use parse::{QuantityError, count, counted, quantity, quantity_of};
pub use relative::{Measure, Relative, relative};

/// Longest decimal form of a number, in characters.
const LONGEST: usize = 20;

/// A number that parses to the same value: `0.004`, or `1e300` if the decimal form would have hundreds of
/// digits.
pub fn number(value: f64) -> String {
    let text = value.to_string();
    if text.len() <= LONGEST { text } else { format!("{value:e}") }
}

/// A value as its author wrote it, shortened for a message: a number with many digits is printed by
/// [`number`], any other text is truncated.
pub fn written(text: &str) -> String {
    match text.parse::<f64>() {
        _ if text.len() <= LONGEST => text.to_owned(),
        Ok(value) => number(value),
        Err(_) if text.chars().count() > 3 * LONGEST => text.chars().take(3 * LONGEST).chain(['…']).collect(),
        Err(_) => text.to_owned(),
    }
}

/// A number in SI units as the language writes it: `0.004 s`. It parses to the same number.
pub fn print(si: f64, dimension: Dimension) -> String {
    let (number, unit) = (number(si), dimension.unit());
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// A ratio as the language writes it: `12.5 %`.
pub fn print_ratio(ratio: f64) -> String {
    let percent = ratio * 100.0;
    let rounded = (percent * 1e9).round() / 1e9;
    format!("{} %", number(rounded))
}

/// A duration in s for people: `0.3 s`, `42 s`, `3 min 20 s`, `2 h 5 min`.
pub fn span(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 60.0 => format!("{s:.0} s"),
        s if s < 3600.0 => format!("{} min {} s", s as u64 / 60, s as u64 % 60),
        s => format!("{} h {} min", s as u64 / 3600, s as u64 % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_takes_more_than_twenty_characters_but_for_its_exponent() {
        for (value, text) in
            [(0.004, "0.004"), (16_384.0, "16384"), (1e300, "1e300"), (5e-324, "5e-324"), (-0.0, "-0")]
        {
            assert_eq!(number(value), text);
            assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
        assert_eq!(number(f64::MAX), "1.7976931348623157e308");
        assert_eq!(print(1e-30, Dimension::LENGTH), "1e-30 m");
        assert_eq!(written(&format!("1{}", "0".repeat(400))), "inf");
        assert_eq!((written("1_000"), written(&"9".repeat(30))), ("1_000".into(), "1e30".into()));
    }

    #[test]
    fn spans_are_written_for_people() {
        let texts: Vec<String> = [0.31, 42.4, 200.0, 7500.0].into_iter().map(span).collect();
        assert_eq!(texts, ["0.3 s", "42 s", "3 min 20 s", "2 h 5 min"]);
    }
}
