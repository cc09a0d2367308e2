//! The possible values of a claim's metric, and of the estimate of its test: a value, a difference of two, a
//! slope or a probability.

use crate::check::subject::short;
use crate::kinds::metric::MetricKind;
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Claim, Over};
use crate::statistics::trend;

/// The minimum and maximum possible value, in SI units; infinite if unbounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The minimum.
    pub low: f64,
    /// The maximum.
    pub high: f64,
}

impl Range {
    /// Whether a number is possible; the ends are included.
    pub fn contains(self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }

    /// The largest difference of two values.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// The largest distance of a value from a number in the range.
    pub fn farthest_from(self, number: f64) -> f64 {
        (self.high - number).max(number - self.low)
    }

    /// `from 0 % to 100 %`, `of 0 N or more`.
    pub fn in_words(self, claim: &Claim, metric: &MetricKind) -> String {
        let written = |end: f64| in_unit(end, claim, metric);
        match (self.low.is_finite(), self.high.is_finite()) {
            (true, true) => format!("from {} to {}", written(self.low), written(self.high)),
            (true, false) => format!("of {} or more", written(self.low)),
            _ => format!("of {} or less", written(self.high)),
        }
    }
}

/// The range of a run's value: the metric, or its difference or ratio to a baseline.
pub fn of_a_run(claim: &Claim, metric: &MetricKind) -> Range {
    let [low, high] = metric.bounds;
    match &claim.baseline {
        None => Range { low, high },
        Some(baseline) if baseline.relative && low >= 0.0 => Range { low: 0.0, high: f64::INFINITY },
        Some(baseline) if baseline.relative => Range { low: f64::NEG_INFINITY, high: f64::INFINITY },
        Some(_) => Range { low: low - high, high: high - low },
    }
}

/// The range of a summary of the arms in the metric's unit: one arm, the difference of two, or the slope over
/// this many points.
pub fn of_the_arms(claim: &Claim, metric: &MetricKind, points: usize) -> Range {
    let run = of_a_run(claim, metric);
    let Range { low, high } = match claim.over {
        // The steepest trend has its first half at one end of the range and its second half at the other.
        Some(Over::Trend(_)) => {
            let weights = trend::weights(points).into_iter();
            let steepest = weights.filter(|weight| *weight > 0.0).sum::<f64>() * run.width();
            Range { low: -steepest, high: steepest }
        }
        _ => run,
    };
    let factor = claim.expect.factor;
    match claim.sides.len() {
        1 => Range { low, high },
        _ => Range { low: low - factor * high, high: high - factor * low },
    }
}

/// The range of the test's estimate.
pub fn of_the_estimate(claim: &Claim, test: &StatisticKind, metric: &MetricKind, points: usize) -> Range {
    match test.method {
        Method::ProbabilityOfImprovement => Range { low: 0.0, high: 1.0 },
        _ => of_the_arms(claim, metric, points),
    }
}

/// A number in the unit that the claim uses.
pub fn in_unit(number: f64, claim: &Claim, metric: &MetricKind) -> String {
    match metric.unit {
        unit if unit.is_empty() || is_ratio(claim) => short(number),
        "%" => format!("{} %", short(100.0 * number)),
        unit => format!("{} {unit}", short(number)),
    }
}

/// Whether the runs' values are ratios to a baseline.
pub fn is_ratio(claim: &Claim) -> bool {
    claim.baseline.as_ref().is_some_and(|baseline| baseline.relative)
}
