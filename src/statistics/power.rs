//! The power of tests of means over runs, and how many runs or episodes would settle a claim.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

use super::proportion::score_test;
use crate::kinds::statistic::{FEW, SMALLEST_OF_FEW};

/// The power that a planned test should have.
pub const TARGET: f64 = 0.8;
/// The most runs per arm or episodes that are looked for.
const MOST: usize = 100_000;
/// Points at which the distribution of the estimated variance is summed.
const POINTS: usize = 400;

/// The chance that Welch's test with `runs` runs per arm establishes, at a two-sided level, that the estimate lies beyond a
/// boundary, when the truth lies so far beyond it. `spreads` are the standard deviations between the runs of each side, the
/// second one's times the factor. `None` without any spread or with fewer than two runs.
pub fn of_means(distance: f64, spreads: &[f64], runs: usize, alpha: f64) -> Option<f64> {
    let variances = || spreads.iter().map(|spread| spread * spread);
    let sum: f64 = variances().sum();
    if runs < 2 || sum <= 0.0 {
        return None;
    }
    if runs < FEW && alpha < SMALLEST_OF_FEW {
        return Some(0.0);
    }
    let freedom = (runs - 1) as f64 * sum * sum / variances().map(|variance| variance * variance).sum::<f64>();
    let critical = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - 0.5 * alpha);
    noncentral_tail(critical, distance / libm::sqrt(sum / runs as f64), freedom)
}

/// The chance that a t statistic with this noncentrality exceeds a number: the normal tail averaged over the distribution of the
/// estimated standard deviation.
fn noncentral_tail(critical: f64, noncentrality: f64, freedom: f64) -> Option<f64> {
    let (chi, normal) = (ChiSquared::new(freedom).ok()?, Normal::standard());
    // Ratios of the estimated to the true deviation, within eight of their own deviations of 1.
    let reach = 8.0 / libm::sqrt(2.0 * freedom);
    let least = (1.0 - reach).max(0.0);
    let step = (1.0 + reach - least) / POINTS as f64;
    let at = |ratio: f64| {
        let density = chi.pdf(ratio * ratio * freedom) * 2.0 * ratio * freedom;
        density * normal.cdf(noncentrality - critical * ratio)
    };
    let sum: f64 = (0..POINTS).map(|point| at(least + (point as f64 + 0.5) * step)).sum();
    Some((sum * step).clamp(0.0, 1.0))
}

/// The fewest runs per arm with which the test has the power [`TARGET`]; `None` when there are too many, or none.
pub fn runs_needed(distance: f64, spreads: &[f64], alpha: f64) -> Option<usize> {
    let distance = distance.abs();
    first(2, |runs| of_means(distance, spreads, runs, alpha).is_some_and(|power| power >= TARGET))
}

/// The distance from the boundary for which the test has the power [`TARGET`].
pub fn detectable(spreads: &[f64], runs: usize, alpha: f64) -> Option<f64> {
    let scale = libm::sqrt(spreads.iter().map(|spread| spread * spread).sum());
    let is_enough = |distance: f64| of_means(distance, spreads, runs, alpha).map(|power| power >= TARGET);
    is_enough(0.0)?;
    let (mut little, mut enough) = (0.0, 1e3 * scale);
    if !is_enough(enough)? {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (little + enough);
        if is_enough(middle)? { enough = middle } else { little = middle }
    }
    Some(enough)
}

/// The fewest episodes whose share, when it stays as it is, lies beyond a boundary at a two-sided level.
pub fn episodes_needed(share: f64, boundary: f64, alpha: f64) -> Option<usize> {
    first(1, |trials| {
        let successes = libm::round(share * trials as f64) as u64;
        score_test(successes, trials as u64, boundary).is_some_and(|p| p <= alpha)
    })
}

/// The fewest runs per arm of which Fisher's exact test of arms that are each all alike has a p value of at most alpha.
pub fn alike_runs_needed(alpha: f64) -> Option<usize> {
    let mut orders = 1.0;
    (1..200).find(|runs| {
        let n = *runs as f64;
        orders *= 2.0 * (2.0 * n - 1.0) / n;
        2.0 / orders <= alpha
    })
}

/// The first number from `least` on for which this holds, as it then does for all larger ones.
fn first(least: usize, holds: impl Fn(usize) -> bool) -> Option<usize> {
    let mut enough = least;
    while !holds(enough) {
        enough *= 2;
        if enough > MOST {
            return None;
        }
    }
    let mut too_few = enough / 2;
    while enough - too_few > 1 && enough > least {
        let middle = too_few.midpoint(enough);
        if holds(middle) { enough = middle } else { too_few = middle }
    }
    Some(enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_of_a_t_test_is_the_published_one() {
        // Cohen 1988: two samples of 17, one standard deviation apart, alpha 0.05: power 0.80; 64 of half a deviation: 0.80.
        for (runs, distance) in [(17, 1.0), (64, 0.5)] {
            let power = of_means(distance, &[1.0, 1.0], runs, 0.05).expect("a power");
            assert!((power - 0.80).abs() < 0.01, "{runs}: {power}");
        }
        assert_eq!(runs_needed(1.0, &[1.0, 1.0], 0.05), Some(17));
        assert_eq!(runs_needed(-0.5, &[1.0, 1.0], 0.05), Some(64));
        // Without a distance the chance is half the level.
        assert!((of_means(0.0, &[1.0, 1.0], 10, 0.05).expect("a power") - 0.025).abs() < 1e-4);
        assert_eq!(of_means(1.0, &[0.0, 0.0], 5, 0.05), None);
        assert_eq!(of_means(99.0, &[1.0, 1.0], 4, 0.001), Some(0.0), "below five runs no p is that small");
    }

    #[test]
    fn what_can_be_detected_needs_the_runs_that_it_was_computed_for() {
        let distance = detectable(&[0.1, 0.1], 5, 0.05).expect("a distance");
        assert_eq!(runs_needed(distance, &[0.1, 0.1], 0.05), Some(5));
        assert_eq!(detectable(&[0.0], 5, 0.05), None);
    }

    #[test]
    fn episodes_and_alike_runs_are_counted() {
        // 122 of 128 is the first share above 90 % of 128 episodes; of a share of 0.95, 128 or so.
        let needed = episodes_needed(0.95, 0.9, 0.05).expect("a number");
        assert!((120..=160).contains(&needed), "{needed}");
        assert_eq!([0.1, 0.05, 0.01].map(alike_runs_needed), [Some(3), Some(4), Some(5)]);
    }
}
