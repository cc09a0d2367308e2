//! The health of a training: what is wrong with it, in words, while it runs.
//!
//! Findings are a function of the metrics alone, so a resumed training has the same. Nothing here
//! changes a training.

pub mod measure;
mod monitor;
mod rules;
#[cfg(test)]
mod tests;

pub use monitor::Monitor;
pub use rules::Norms;
