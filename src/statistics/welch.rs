//! Means of few independent values by Student's t: one sample against a number, two samples with unequal
//! variances (Welch 1947).

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Interval;
use super::summary::{deviation, mean};

/// An estimate with a t distribution around its true value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean, or the difference of the means.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
    /// Degrees of freedom.
    pub freedom: f64,
}

/// The mean of one sample; `None` with fewer than two values or without any spread.
pub fn one(values: &[f64]) -> Option<Estimate> {
    contrast(&[(1.0, values)])
}

/// The difference of two means, first minus second, with Satterthwaite's degrees of freedom; `None` if a
/// sample has fewer than two values or neither has any spread.
pub fn two(first: &[f64], second: &[f64]) -> Option<Estimate> {
    contrast(&[(1.0, first), (-1.0, second)])
}

/// A weighted sum of the means of independent samples with unequal variances (Welch 1947), with
/// Satterthwaite's degrees of freedom; `None` if a sample has fewer than two values or none has any spread.
pub fn contrast(samples: &[(f64, &[f64])]) -> Option<Estimate> {
    let (mut value, mut variance, mut inverse_freedom) = (0.0, 0.0, 0.0);
    for (weight, values) in samples {
        let deviation = weight * deviation(values)?;
        let own = deviation * deviation / values.len() as f64;
        value += weight * mean(values)?;
        variance += own;
        inverse_freedom += own * own / (values.len() - 1) as f64;
    }
    (variance > 0.0).then(|| Estimate {
        value,
        error: libm::sqrt(variance),
        freedom: variance * variance / inverse_freedom,
    })
}

impl Estimate {
    /// The interval with this confidence.
    pub fn interval(&self, confidence: f64) -> Option<Interval> {
        let t = StudentsT::new(0.0, 1.0, self.freedom).ok()?.inverse_cdf(0.5 + 0.5 * confidence);
        Some(Interval { low: self.value - t * self.error, high: self.value + t * self.error })
    }

    /// Two-sided p value of the true value being `boundary`.
    pub fn p(&self, boundary: f64) -> Option<f64> {
        let t = StudentsT::new(0.0, 1.0, self.freedom).ok()?;
        Some((2.0 * t.cdf(-((self.value - boundary) / self.error).abs())).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_without_spread_or_of_one_value_have_no_estimate() {
        assert_eq!(one(&[1.0, 1.0, 1.0]), None);
        assert_eq!(two(&[1.0, 1.0], &[0.0, 0.0]), None);
        assert_eq!(two(&[1.0], &[0.0, 0.5]), None);
    }

    #[test]
    fn a_mean_over_strata_has_the_variance_of_its_parts() {
        let (low, high) = ([1.0, 2.0, 3.0], [11.0, 13.0, 15.0]);
        let both = contrast(&[(0.5, &low), (0.5, &high)]).expect("spread");
        // Variances of the means 1/3 and 4/3, a quarter of each: 5/12; freedom (5/12)^2 / ((1/12)^2 / 2 +
        // (4/12)^2 / 2).
        assert!(
            (both.value - 7.5).abs() < 1e-12 && (both.error - libm::sqrt(5.0 / 12.0)).abs() < 1e-12,
            "{both:?}"
        );
        assert!((both.freedom - 50.0 / 17.0).abs() < 1e-12, "{both:?}");
    }

    #[test]
    fn one_sample_is_students_test_of_the_sleep_data() {
        // Student 1908, paired differences: t = 4.0621 on 9 degrees of freedom, p = 0.002833.
        let gain = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let estimate = one(&gain).expect("ten values");
        assert!((estimate.p(0.0).expect("a p") - 0.002_832_89).abs() < 1e-7);
        let interval = estimate.interval(0.95).expect("an interval");
        assert!((interval.low - 0.700_114_2).abs() < 1e-6 && (interval.high - 2.459_885_8).abs() < 1e-6);
    }
}
