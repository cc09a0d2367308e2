//! Physical quantities of the spec language: dimensions, units, parsing and printing.
//!
//! Inside the program every number is SI and without a unit in its name; units live here, at the
//! language border. Knows nothing of TOML.

pub mod dimension;

pub use dimension::Dimension;
