//! Health of a training: detects problems while it runs and describes them.
//!
//! Findings are a function of the metrics alone, so a resumed training reports the same ones. Nothing here
//! changes a training.

pub mod measure;
mod monitor;
mod rules;
#[cfg(test)]
mod tests;

pub use monitor::Monitor;
pub use rules::Norms;
