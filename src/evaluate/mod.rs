//! Evaluation protocols and what they measure.

pub mod gait;
pub mod meter;
pub mod outcome;

pub use outcome::{Episode, Evaluation, Trace};
