//! Estimates with confidence intervals: proportions, means, differences, and summaries of samples; the tests
//! of claims and their expected regions.
//!
//! Episodes are the unit for statements about one policy; runs (seeds) are the unit for statements
//! about a method (Agarwal et al. 2021). All resampling draws from a named stream.

pub mod alike;
pub mod assumed;
pub mod difference;
pub mod failure;
pub mod invert;
pub mod mean;
pub mod multiplicity;
pub mod power;
pub mod proportion;
pub mod rank;
pub mod region;
pub mod resample;
pub mod summary;
pub mod test;
pub mod trend;
pub mod welch;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// The confidence of every interval in a report.
pub const CONFIDENCE: f64 = 0.95;

/// A closed interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether the value lies inside or on an end of the interval.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// The standard normal quantile that leaves `(1 - confidence) / 2` on each side; 1.959964 at 0.95.
pub fn normal_quantile(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
}
