//! Physical quantities of the spec language: dimensions, units, parsing and printing.
//!
//! Inside the program every number is SI and without a unit in its name; units live here, at the
//! language border. Knows nothing of TOML.

pub mod dimension;
pub mod parse;
pub mod unit;

pub use dimension::Dimension;
pub use parse::{QuantityError, count, quantity, quantity_of};

/// A number in SI units as the language writes it: `0.004 s`. Reading it gives the same number.
pub fn print(si: f64, dimension: Dimension) -> String {
    let unit = dimension.unit();
    if unit.is_empty() { format!("{si}") } else { format!("{si} {unit}") }
}

/// A ratio as the language writes it: `12.5 %`.
pub fn print_ratio(ratio: f64) -> String {
    let percent = ratio * 100.0;
    let rounded = (percent * 1e9).round() / 1e9;
    format!("{rounded} %")
}
