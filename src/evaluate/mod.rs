//! Evaluation protocols and what they measure.

pub mod outcome;
