//! Proportions: intervals and tests for counts of successes.

use statrs::distribution::{ContinuousCDF, Normal};
use statrs::function::factorial::ln_binomial;

use super::{Interval, normal_quantile};

/// Wilson's score interval for `successes` of `trials` (Wilson 1927); all of [0, 1] without trials.
pub fn wilson(successes: u64, trials: u64, confidence: f64) -> Interval {
    if trials == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let (x, n, z) = (successes as f64, trials as f64, normal_quantile(confidence));
    let share = x / n;
    let scale = 1.0 / (1.0 + z * z / n);
    let centre = scale * (share + z * z / (2.0 * n));
    let half = scale * z * libm::sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n));
    // At the ends the formula gives exactly 0 and 1; rounding must not change that.
    let low = if successes == 0 { 0.0 } else { centre - half };
    let high = if successes == trials { 1.0 } else { centre + half };
    Interval { low, high }
}

/// Two-sided score test for a share being `expected`, consistent with Wilson's interval; `None` without
/// trials, or if the expected share is 0 or 1.
pub fn score_test(successes: u64, trials: u64, expected: f64) -> Option<f64> {
    if trials == 0 || expected <= 0.0 || expected >= 1.0 {
        return None;
    }
    let n = trials as f64;
    let z = (successes as f64 / n - expected) / libm::sqrt(expected * (1.0 - expected) / n);
    Some((2.0 * Normal::standard().cdf(-z.abs())).min(1.0))
}

/// Two-sided exact McNemar test from the two discordant counts (pairs where only the first, only the
/// second succeeded): the binomial test of equal chance.
pub fn mcnemar_exact(only_first: u64, only_second: u64) -> f64 {
    let n = only_first + only_second;
    let fewer = only_first.min(only_second);
    let tail: f64 =
        (0..=fewer).map(|k| libm::exp(ln_binomial(n, k) - n as f64 * std::f64::consts::LN_2)).sum();
    (2.0 * tail).min(1.0)
}

/// Two-sided Fisher exact test of two independent proportions: the sum over all tables with the same margins
/// that are at most as likely as the observed one.
pub fn fisher_exact(first: [u64; 2], second: [u64; 2]) -> f64 {
    let ([a, n], [b, m]) = (first, second);
    let total = a + b;
    let log_chance = |k: u64| ln_binomial(n, k) + ln_binomial(m, total - k) - ln_binomial(n + m, total);
    let seen = log_chance(a);
    // Equally likely tables differ by rounding only.
    let sum: f64 = (total.saturating_sub(m)..=total.min(n))
        .map(log_chance)
        .filter(|chance| *chance <= seen + 1e-7)
        .map(libm::exp)
        .sum();
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(interval: Interval, digits: i32) -> (f64, f64) {
        let scale = 10f64.powi(digits);
        ((interval.low * scale).round() / scale, (interval.high * scale).round() / scale)
    }

    #[test]
    fn wilson_gives_the_published_intervals_of_small_and_large_samples() {
        // Experiments 5 and 7 of the paper, re-analysed.
        assert_eq!(rounded(wilson(15, 25, 0.95), 2), (0.41, 0.77));
        assert_eq!(rounded(wilson(18, 25, 0.95), 2), (0.52, 0.86));
        assert_eq!(rounded(wilson(22, 25, 0.95), 2), (0.70, 0.96));
        assert_eq!(rounded(wilson(25, 25, 0.95), 2), (0.87, 1.00));
        assert_eq!(rounded(wilson(3477, 4870, 0.95), 2), (0.70, 0.73));
        assert_eq!(rounded(wilson(3604, 4870, 0.95), 2), (0.73, 0.75));
        // Newcombe 1998, Statistics in Medicine 17:857, table I, method 3.
        assert_eq!(rounded(wilson(81, 263, 0.95), 4), (0.2553, 0.3662));
        assert_eq!(rounded(wilson(15, 148, 0.95), 4), (0.0624, 0.1605));
        assert_eq!(rounded(wilson(0, 20, 0.95), 4), (0.0, 0.1611));
        assert_eq!(rounded(wilson(1, 29, 0.95), 4), (0.0061, 0.1718));
    }

    #[test]
    fn the_score_test_rejects_what_wilsons_interval_leaves_out() {
        let ends = wilson(15, 25, 0.95);
        for end in [ends.low, ends.high] {
            assert!((score_test(15, 25, end).expect("trials") - 0.05).abs() < 1e-9);
        }
        // (0.6 - 0.5) / sqrt(0.25 / 25) = 1, so 0.3173.
        assert!((score_test(15, 25, 0.5).expect("trials") - 0.317_310_5).abs() < 1e-7);
        assert_eq!((score_test(0, 0, 0.5), score_test(3, 4, 1.0)), (None, None));
    }

    #[test]
    fn no_trials_tell_nothing() {
        assert_eq!(wilson(0, 0, 0.95), Interval { low: 0.0, high: 1.0 });
    }

    #[test]
    fn mcnemar_is_the_binomial_test_of_the_discordant_pairs() {
        // (1 + 12 + 66) / 4096 in each tail.
        assert!((mcnemar_exact(10, 2) - 2.0 * 79.0 / 4096.0).abs() < 1e-12);
        assert!((mcnemar_exact(2, 10) - mcnemar_exact(10, 2)).abs() < 1e-15);
        assert_eq!(mcnemar_exact(0, 0), 1.0);
        assert_eq!(mcnemar_exact(3, 3), 1.0);
    }

    #[test]
    fn fisher_gives_the_published_values_of_experiment_5() {
        let round = |p: f64, digits: i32| (p * 10f64.powi(digits)).round() / 10f64.powi(digits);
        assert_eq!(round(fisher_exact([15, 25], [25, 25]), 4), 0.0006);
        assert_eq!(round(fisher_exact([18, 25], [25, 25]), 4), 0.0096);
        assert_eq!(round(fisher_exact([22, 25], [25, 25]), 2), 0.23);
        // Fisher's tea: three of four against one of four.
        assert!((fisher_exact([3, 4], [1, 4]) - 34.0 / 70.0).abs() < 1e-9);
    }
}
