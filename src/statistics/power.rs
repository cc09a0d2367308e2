//! The power of tests of means over runs, and the number of runs or episodes that would settle a claim.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

use super::proportion::score_test;
use crate::kinds::statistic::{FEW, SMALLEST_OF_FEW};

/// The power that a planned test should have.
pub const TARGET: f64 = 0.8;
/// Largest number of runs per arm or episodes that is considered.
const MOST: usize = 100_000;
/// Largest number of runs per arm that is considered if several comparisons are computed for each number.
pub const MOST_RUNS: usize = 1 << 14;
/// Number of points for summing over the distribution of the estimated variance.
const POINTS: usize = 400;

/// One side of a comparison of means over runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// The standard deviation between its runs, times the factor of the claim.
    pub spread: f64,
    /// Number of runs.
    pub runs: usize,
}

impl Arm {
    /// The squared standard error of its mean.
    fn square(&self) -> f64 {
        self.spread * self.spread / self.runs as f64
    }
}

/// From this many runs per arm, the degrees of freedom of Welch's test are computed from the true spreads.
const MANY: usize = 8;
/// Number of points for summing over the distribution of each arm's estimated variance.
const POINTS_OF_FEW: usize = 40;

/// Probability that Welch's test of a sum of means finds, at a two-sided level, that the estimate lies beyond
/// a boundary, if the true value lies this far beyond it: of one arm, of two, or of the arms of several strata,
/// whose spreads are then multiplied by their weights. Arms may have different numbers of runs. `None` without
/// any spread or with fewer than two runs in an arm.
pub fn of_arms(distance: f64, arms: &[Arm], alpha: f64) -> Option<f64> {
    let fewest = arms.iter().map(|arm| arm.runs).min()?;
    let squares: f64 = arms.iter().map(Arm::square).sum();
    if fewest < 2 || squares <= 0.0 {
        return None;
    }
    if fewest < FEW && alpha < SMALLEST_OF_FEW {
        return Some(0.0);
    }
    let of_one_size = arms.iter().all(|arm| arm.runs == fewest);
    if fewest >= MANY && of_one_size || arms.len() > 2 {
        return of_many(distance, arms, alpha);
    }
    let draws: Vec<Vec<Share>> = arms.iter().map(|arm| estimates(*arm)).collect::<Option<_>>()?;
    let certain = vec![Share { square: 0.0, squared_over_freedom: 0.0, weight: 1.0 }];
    let (first, second) = (&draws[0], draws.get(1).unwrap_or(&certain));
    let (normal, error) = (Normal::standard(), libm::sqrt(squares));
    let mut power = 0.0;
    for one in first {
        for two in second {
            let square = one.square + two.square;
            let freedom = square * square / (one.squared_over_freedom + two.squared_over_freedom);
            let critical = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - 0.5 * alpha);
            power += one.weight * two.weight * normal.cdf((distance - critical * libm::sqrt(square)) / error);
        }
    }
    Some(power.clamp(0.0, 1.0))
}

/// A possible value of the estimated variance of an arm's mean.
#[derive(Clone, Copy, Debug)]
struct Share {
    /// The squared standard error.
    square: f64,
    /// Its square over the degrees of freedom.
    squared_over_freedom: f64,
    /// Its probability.
    weight: f64,
}

/// Equally probable values of the estimated variance of an arm's mean: the quantiles of its distribution.
fn estimates(arm: Arm) -> Option<Vec<Share>> {
    let freedom = (arm.runs - 1) as f64;
    let chi = ChiSquared::new(freedom).ok()?;
    let share = |point: usize| {
        let ratio = chi.inverse_cdf((point as f64 + 0.5) / POINTS_OF_FEW as f64) / freedom;
        let square = (arm.square() * ratio).max(1e-300);
        Share { square, squared_over_freedom: square * square / freedom, weight: 1.0 / POINTS_OF_FEW as f64 }
    };
    Some((0..POINTS_OF_FEW).map(share).collect())
}

/// [`of_arms`] with the same number of runs in each arm. `spreads` are the standard deviations between the
/// runs of each side, the second one's times the factor.
pub fn of_means(distance: f64, spreads: &[f64], runs: usize, alpha: f64) -> Option<f64> {
    let arms: Vec<Arm> = spreads.iter().map(|spread| Arm { spread: *spread, runs }).collect();
    of_arms(distance, &arms, alpha)
}

/// [`of_arms`] with the degrees of freedom from the true spreads, which must not all be zero.
fn of_many(distance: f64, arms: &[Arm], alpha: f64) -> Option<f64> {
    let sum: f64 = arms.iter().map(Arm::square).sum();
    let parts = arms.iter().map(|arm| arm.square() * arm.square() / (arm.runs - 1) as f64);
    let freedom = sum * sum / parts.sum::<f64>();
    let critical = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - 0.5 * alpha);
    noncentral_tail(critical, distance / libm::sqrt(sum), freedom)
}

/// Probability that a t statistic with this noncentrality exceeds a number: the normal tail averaged over the
/// distribution of the estimated standard deviation.
fn noncentral_tail(critical: f64, noncentrality: f64, freedom: f64) -> Option<f64> {
    let (chi, normal) = (ChiSquared::new(freedom).ok()?, Normal::standard());
    // Ratios of the estimated to the true deviation, within eight of their standard deviations around 1.
    let reach = 8.0 / libm::sqrt(2.0 * freedom);
    let least = (1.0 - reach).max(0.0);
    let step = (1.0 + reach - least) / POINTS as f64;
    let at = |ratio: f64| {
        // The density itself overflows from 119 runs on.
        let density = libm::exp(chi.ln_pdf(ratio * ratio * freedom)) * 2.0 * ratio * freedom;
        density * normal.cdf(noncentrality - critical * ratio)
    };
    let sum: f64 = (0..POINTS).map(|point| at(least + (point as f64 + 0.5) * step)).sum();
    Some((sum * step).clamp(0.0, 1.0))
}

/// Smallest number of runs per arm with which the test has the power [`TARGET`]; `None` if it is too large or
/// does not exist.
pub fn runs_needed(distance: f64, spreads: &[f64], alpha: f64) -> Option<usize> {
    let distance = distance.abs();
    first(2, |runs| of_means(distance, spreads, runs, alpha).is_some_and(|power| power >= TARGET))
}

/// The distance from the boundary at which this power, which rises with the distance, is [`TARGET`], for runs
/// that spread by `scale`. `None` where no distance gives it or the power is not defined.
pub fn detectable(scale: f64, power: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let is_enough = |distance: f64| power(distance).map(|power| power >= TARGET);
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

/// Smallest number of episodes per policy for which a difference this far from its boundary is detected with
/// the power [`TARGET`], if one episode (or pair of episodes) has this variance. `None` without a distance or
/// a variance, or if the number is too large.
pub fn observations_needed(distance: f64, variance: f64, alpha: f64) -> Option<usize> {
    let normal = Normal::standard();
    let reach = normal.inverse_cdf(1.0 - 0.5 * alpha) + normal.inverse_cdf(TARGET);
    let needed = libm::ceil(variance * (reach / distance) * (reach / distance));
    (variance > 0.0 && needed.is_finite() && needed <= MOST as f64).then_some((needed as usize).max(2))
}

/// Smallest number of runs per arm with which the order of two arms is established with the power [`TARGET`],
/// if a run of one arm exceeds one of the other with this probability (Noether 1987, J. Am. Stat. Assoc.
/// 82:645), and at least as many as the exact test needs for such a p value. `None` if neither arm is ahead,
/// or if the number is too large.
pub fn ranks_needed(chance: f64, least: usize, alpha: f64) -> Option<usize> {
    let ahead = (chance - 0.5).abs();
    let normal = Normal::standard();
    let reach = normal.inverse_cdf(1.0 - 0.5 * alpha) + normal.inverse_cdf(TARGET);
    let needed = libm::ceil(reach * reach / (6.0 * ahead * ahead));
    (needed.is_finite() && needed <= MOST as f64).then_some((needed as usize).max(least))
}

/// Smallest number of times that the observed outcomes must be repeated for a condition to hold; `None` if it
/// is too large.
pub fn times_needed(observed: usize, holds: impl Fn(usize) -> bool) -> Option<usize> {
    let most = MOST / observed.max(1);
    (1..=most).find(|times| holds(*times))
}

/// Smallest number of episodes for which the share, if it stays the same, lies beyond a boundary at a
/// two-sided level.
pub fn episodes_needed(share: f64, boundary: f64, alpha: f64) -> Option<usize> {
    first(1, |trials| {
        let successes = libm::round(share * trials as f64) as u64;
        score_test(successes, trials as u64, boundary).is_some_and(|p| p <= alpha)
    })
}

/// Smallest number of runs per arm for which Fisher's exact test of arms without spread has a p value of at
/// most alpha.
pub fn alike_runs_needed(alpha: f64) -> Option<usize> {
    let mut orders = 1.0;
    (1..200).find(|runs| {
        let n = *runs as f64;
        orders *= 2.0 * (2.0 * n - 1.0) / n;
        2.0 / orders <= alpha
    })
}

/// The first number from `least` on for which this holds; it must then hold for all larger ones.
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
    use crate::statistics::difference::Pairs;
    use crate::stream::Stream;

    #[test]
    fn the_power_of_a_t_test_is_the_published_one() {
        // Cohen 1988: two samples of 17, one standard deviation apart, alpha 0.05: power 0.80; 64 of half a
        // deviation: 0.80.
        for (runs, distance) in [(17, 1.0), (64, 0.5)] {
            let power = of_means(distance, &[1.0, 1.0], runs, 0.05).expect("a power");
            assert!((power - 0.80).abs() < 0.01, "{runs}: {power}");
        }
        assert_eq!(runs_needed(1.0, &[1.0, 1.0], 0.05), Some(17));
        assert_eq!(runs_needed(-0.5, &[1.0, 1.0], 0.05), Some(64));
        // 0.2 of a deviation: 394 runs (393.4); of many runs the normal theory is near: 2 (2.802 / 0.15)^2 = 698.
        assert_eq!(runs_needed(0.2, &[1.0, 1.0], 0.05), Some(394));
        let many = runs_needed(0.15, &[1.0, 1.0], 0.05).expect("a number");
        assert!((698..=700).contains(&many), "{many}");
        assert!(of_means(0.2, &[1.0, 1.0], 200, 0.05).is_some_and(|power| (power - 0.514).abs() < 0.005));
        // At zero distance the probability is half the level.
        assert!((of_means(0.0, &[1.0, 1.0], 10, 0.05).expect("a power") - 0.025).abs() < 1e-4);
        assert_eq!(of_means(1.0, &[0.0, 0.0], 5, 0.05), None);
        assert_eq!(of_means(99.0, &[1.0, 1.0], 4, 0.001), Some(0.0), "below five runs no p is that small");
    }

    #[test]
    fn the_power_of_few_and_of_unequal_runs_is_that_of_simulated_tests() {
        // Exp. 6: 0.15 beyond the boundary, standard deviations of 0.03, level 0.01.
        for runs in [[3, 3], [3, 2], [2, 2], [5, 3]] {
            let mut stream = Stream::new(&format!("test/power/{runs:?}"));
            let mut draw = |runs: usize, mean: f64| {
                (0..runs).map(|_| mean + 0.03 * stream.normal()).collect::<Vec<f64>>()
            };
            let passes = |a: &[f64], b: &[f64]| {
                let found = crate::statistics::welch::two(a, b).expect("a spread");
                found.p(0.0).expect("a p").max(SMALLEST_OF_FEW) <= 0.01
            };
            let count = (0..4000).filter(|_| passes(&draw(runs[0], 0.15), &draw(runs[1], 0.0))).count();
            let simulated = count as f64 / 4000.0;
            let arms = runs.map(|runs| Arm { spread: 0.03, runs });
            let power = of_arms(0.15, &arms, 0.01).expect("a power");
            assert!((power - simulated).abs() < 0.03, "{runs:?}: {power} and {simulated}");
        }
    }

    #[test]
    fn the_power_of_a_mean_over_strata_is_that_of_simulated_tests() {
        // Six strata of two arms, as many standard deviations from the boundary as leave the test open at times.
        for (runs, distance) in [(3, 1.6), (6, 1.1)] {
            let mut stream = Stream::new(&format!("test/power/strata/{runs}"));
            let mut passes = || {
                let mut draw = |mean: f64| (0..runs).map(|_| mean + stream.normal()).collect::<Vec<f64>>();
                let arms: Vec<[Vec<f64>; 2]> = (0..6).map(|_| [draw(distance), draw(0.0)]).collect();
                let sides = |[a, b]: &'_ [Vec<f64>; 2]| [(1.0 / 6.0, a.clone()), (-1.0 / 6.0, b.clone())];
                let samples: Vec<(f64, Vec<f64>)> = arms.iter().flat_map(sides).collect();
                let samples: Vec<(f64, &[f64])> =
                    samples.iter().map(|(weight, runs)| (*weight, runs.as_slice())).collect();
                let found = crate::statistics::welch::contrast(&samples).expect("a spread");
                found.value > 0.0 && found.p(0.0).expect("a p") <= 0.01
            };
            let simulated = (0..2000).filter(|_| passes()).count() as f64 / 2000.0;
            let power = of_arms(distance, &[Arm { spread: 1.0 / 6.0, runs }; 12], 0.01).expect("a power");
            assert!((power - simulated).abs() < 0.03, "{runs}: {power} and {simulated}");
        }
    }

    #[test]
    fn the_episodes_that_are_needed_have_the_power_that_they_were_computed_for() {
        // Paired outcomes: 10 % only the first, 4 % only the second.
        let (only_first, only_second) = (0.10, 0.04);
        let variance = only_first + only_second - 0.06 * 0.06;
        let episodes = observations_needed(0.06, variance, 0.05).expect("a number");
        let mut stream = Stream::new("test/power/pairs");
        let mut pairs = || {
            let mut pairs = Pairs::default();
            for _ in 0..episodes {
                match stream.uniform() {
                    draw if draw < only_first => pairs.only_first += 1,
                    draw if draw < only_first + only_second => pairs.only_second += 1,
                    draw if draw < 0.9 => pairs.both += 1,
                    _ => pairs.neither += 1,
                }
            }
            pairs.difference(0.95).1.low > 0.0
        };
        let power = (0..2000).filter(|_| pairs()).count() as f64 / 2000.0;
        assert!((power - TARGET).abs() < 0.05, "{episodes} episodes: {power}");
        assert_eq!(observations_needed(0.0, variance, 0.05), None);
        assert_eq!(observations_needed(0.1, 0.0, 0.05), None);
    }

    #[test]
    fn the_ranked_runs_that_are_needed_have_the_power_that_they_were_computed_for() {
        // Normal arms one standard deviation apart: a run of the first exceeds one of the second with a
        // probability of 76 %.
        let runs = ranks_needed(0.760, 4, 0.05).expect("a number");
        let mut stream = Stream::new("test/power/ranks");
        let mut passes = || {
            let mut draw = |mean: f64| (0..runs).map(|_| mean + stream.normal()).collect::<Vec<f64>>();
            let (first, second) = (draw(1.0), draw(0.0));
            crate::statistics::rank::mann_whitney(&first, &second).is_some_and(|p| p <= 0.05)
        };
        let power = (0..1000).filter(|_| passes()).count() as f64 / 1000.0;
        assert!((power - TARGET).abs() < 0.07, "{runs} runs: {power}");
        assert_eq!((ranks_needed(0.5, 4, 0.05), ranks_needed(1.0, 12, 0.05)), (None, Some(12)));
    }

    #[test]
    fn what_can_be_detected_needs_the_runs_that_it_was_computed_for() {
        let of = |spreads: &'static [f64]| move |distance: f64| of_means(distance, spreads, 5, 0.05);
        let distance = detectable(0.1, of(&[0.1, 0.1])).expect("a distance");
        assert_eq!(runs_needed(distance, &[0.1, 0.1], 0.05), Some(5));
        assert_eq!(detectable(0.0, of(&[0.0])), None);
    }

    #[test]
    fn episodes_and_alike_runs_are_counted() {
        // 122 of 128 is the first share above 90 % of 128 episodes; with a share of 0.95, about 128 are
        // needed.
        let needed = episodes_needed(0.95, 0.9, 0.05).expect("a number");
        assert!((120..=160).contains(&needed), "{needed}");
        assert_eq!([0.1, 0.05, 0.01].map(alike_runs_needed), [Some(3), Some(4), Some(5)]);
    }
}
