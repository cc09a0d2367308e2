//! A number with its unit, interval and sample size: the form of every value in a template.

use serde::{Deserialize, Serialize};

use crate::statistics::summary::mean;
use crate::statistics::{CONFIDENCE, Interval, mean::bootstrap, proportion::wilson};
use crate::stream::Stream;

/// A number in a report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The value in SI units; a fraction for the unit `%`. Absent if not measured.
    pub value: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval.
    pub high: Option<f64>,
    /// Number of observations, for a statistic.
    pub n: Option<usize>,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Number of decimals to print (of per cents for the unit `%`).
    pub digits: usize,
}

impl Estimate {
    /// A number without interval or sample size.
    pub fn exact(value: f64, unit: &str, digits: usize) -> Self {
        Self { value: Some(value), unit: unit.to_string(), digits, ..Self::default() }
    }

    /// A number that may be missing.
    pub fn maybe(value: Option<f64>, unit: &str, digits: usize) -> Self {
        Self { value, unit: unit.to_string(), digits, ..Self::default() }
    }

    /// A share of successes with its Wilson interval.
    pub fn share(outcomes: &[bool]) -> Self {
        let (successes, n) = (outcomes.iter().filter(|outcome| **outcome).count(), outcomes.len());
        let interval = (n > 0).then(|| wilson(successes as u64, n as u64, CONFIDENCE));
        let value = (n > 0).then(|| successes as f64 / n as f64);
        Self { value, n: Some(n), unit: "%".to_string(), ..Self::default() }.within(interval)
    }

    /// A mean with its bootstrap interval. `name` is the measured quantity and seeds the random stream, so
    /// that the interval is the same wherever the number is printed.
    pub fn mean(values: &[f64], unit: &str, digits: usize, name: &str) -> Self {
        let interval =
            bootstrap(&[values], CONFIDENCE, &mut Stream::new(&format!("report/bootstrap/{name}")));
        let empty = Self { value: mean(values), n: Some(values.len()), ..Self::default() };
        Self { unit: unit.to_string(), digits, ..empty }.within(interval)
    }

    /// The same number with this interval.
    pub fn within(self, interval: Option<Interval>) -> Self {
        Self { low: interval.map(|ends| ends.low), high: interval.map(|ends| ends.high), ..self }
    }

    /// The interval.
    pub fn interval(&self) -> Option<Interval> {
        self.low.zip(self.high).map(|(low, high)| Interval { low, high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_has_the_count_and_wilsons_interval() {
        let share = Estimate::share(&[true, true, true, false]);
        assert_eq!((share.value, share.n, share.unit.as_str()), (Some(0.75), Some(4), "%"));
        assert_eq!(share.interval(), Some(wilson(3, 4, 0.95)));
    }

    #[test]
    fn one_observation_has_no_interval_and_none_has_no_value() {
        let one = Estimate::mean(&[2.0], "m", 2, "test");
        assert_eq!((one.value, one.interval()), (Some(2.0), None));
        assert_eq!(Estimate::mean(&[], "m", 2, "test").value, None);
        assert_eq!(Estimate::share(&[]).value, None);
    }
}
