//! Tests for runs without any spread: all runs of an arm have the same value, so no variance can be estimated
//! from them.
//!
//! Two arms with different values: Fisher's exact test over the runs. Two arms with the same share of
//! episodes, or one arm's share against a number: the pooled episodes of all runs. Other values against a
//! number: the sign test over the runs.

use statrs::function::factorial::ln_binomial;

use super::difference::independent;
use super::invert::two_sided;
use super::proportion::score_test;
use super::resample::Strata;
use super::summary::mean;

/// Samples whose runs are all equal within each stratum.
#[derive(Clone, Copy, Debug)]
pub struct Alike<'a> {
    /// The runs by side and stratum.
    pub sides: &'a [Strata],
    /// Number of episodes behind each run's share; `None` if the values are not shares of episodes.
    pub episodes: Option<usize>,
}

impl<'a> Alike<'a> {
    /// The samples, if every stratum has at least two runs and all of its runs are equal.
    pub fn of(sides: &'a [Strata], episodes: Option<usize>) -> Option<Self> {
        let is_alike = |runs: &Vec<f64>| runs.len() > 1 && runs.iter().all(|run| *run == runs[0]);
        let strata = || sides.iter().flatten();
        (strata().next().is_some() && strata().all(is_alike)).then_some(Self { sides, episodes })
    }

    /// Two-sided p value for the mean, or the difference of the means, being equal to `boundary`.
    pub fn p(&self, boundary: f64) -> Option<f64> {
        match self.sides {
            [one] => self.against_number(one, boundary),
            [first, second] => self.against_arm(first, second, boundary),
            _ => None,
        }
    }

    /// Whether both arms have the same share of episodes.
    pub fn is_of_one_share(&self) -> bool {
        let [first, second] = self.sides else { return false };
        let is_same = |(a, b): (&Vec<f64>, &Vec<f64>)| a[0] == b[0];
        self.episodes.is_some() && first.len() == 1 && first.iter().zip(second).all(is_same)
    }

    fn against_number(&self, side: &Strata, boundary: f64) -> Option<f64> {
        let value = centre(side)?;
        if value == boundary {
            return Some(1.0);
        }
        let runs: usize = side.iter().map(Vec::len).sum();
        match self.episodes.filter(|_| side.len() == 1) {
            Some(episodes) if 0.0 < boundary && boundary < 1.0 => {
                let trials = (runs * episodes) as u64;
                score_test(successes(value, trials), trials, boundary)
            }
            _ => Some((2.0 * libm::pow(0.5, runs as f64)).min(1.0)),
        }
    }

    fn against_arm(&self, first: &Strata, second: &Strata, boundary: f64) -> Option<f64> {
        let pairs = || first.iter().zip(second);
        let episodes = self.episodes.filter(|_| boundary != 0.0 && self.is_of_one_share());
        if let Some(episodes) = episodes {
            let count = |side: &Strata| {
                let trials = (side[0].len() * episodes) as u64;
                [successes(side[0][0], trials), trials]
            };
            let counts = [count(first), count(second)];
            return two_sided(0.0, boundary, &|confidence| {
                Some(independent(counts[0], counts[1], confidence).1)
            });
        }
        // Every stratum is a separate table; under the null hypothesis their extreme orders are independent.
        let is_beyond = |above: bool| {
            pairs().all(|(a, b)| if above { a[0] - boundary > b[0] } else { a[0] - boundary < b[0] })
        };
        if !is_beyond(true) && !is_beyond(false) {
            return Some(1.0);
        }
        // One of all orders of the runs.
        let one_sided = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            let (n, m) = (a.len() as u64, b.len() as u64);
            libm::exp(-ln_binomial(n + m, n))
        };
        Some((2.0 * pairs().map(one_sided).product::<f64>()).min(1.0))
    }
}

/// The mean over the strata of their single value.
fn centre(strata: &Strata) -> Option<f64> {
    mean(&strata.iter().map(|runs| runs[0]).collect::<Vec<_>>())
}

/// The successes among `trials` trials at this share.
fn successes(share: f64, trials: u64) -> u64 {
    libm::round(share * trials as f64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(first: &[f64], second: &[f64], episodes: Option<usize>, boundary: f64) -> f64 {
        let sides = [vec![first.to_vec()], vec![second.to_vec()]];
        Alike::of(&sides, episodes).expect("alike").p(boundary).expect("a p")
    }

    #[test]
    fn arms_of_different_values_are_decided_by_fishers_test_over_the_runs() {
        // 2 / C(6, 3), 2 / C(8, 4), 2 / C(10, 5).
        for (runs, expected) in [(3, 0.1), (4, 2.0 / 70.0), (5, 2.0 / 252.0)] {
            let found = p(&vec![1.0; runs], &vec![0.0; runs], Some(96), 0.0);
            assert!((found - expected).abs() < 1e-9, "{runs} runs: {found}");
        }
        assert!(
            (p(&[1.0; 5], &[0.5; 5], Some(96), 0.2) - 2.0 / 252.0).abs() < 1e-9,
            "30 points beyond the boundary"
        );
        assert_eq!(p(&[1.0; 3], &[1.0; 3], Some(96), 0.0), 1.0);
        // Unequal numbers of runs: the opposite extreme is impossible, so the single tail is doubled.
        assert!((p(&[1.0; 3], &[0.0; 5], None, 0.0) - 2.0 / 56.0).abs() < 1e-9);
    }

    #[test]
    fn arms_of_one_share_are_told_from_a_difference_by_their_episodes() {
        // 288 of 288 twice: Wilson's lower end at z is 288 / (288 + z^2), so a boundary of 5 percentage
        // points is reached at z^2 = 288 / 19.
        let expected = 2.0 * 0.5 * libm::erfc(libm::sqrt(288.0 / 19.0 / 2.0));
        let found = p(&[1.0; 3], &[1.0; 3], Some(96), 0.05);
        assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
        assert!((p(&[1.0; 3], &[1.0; 3], Some(96), -0.05) - expected).abs() < 1e-6);
        // Without episodes behind them, equal values only have their order, shifted by the boundary.
        assert!((p(&[2.0; 4], &[2.0; 4], None, 0.5) - 2.0 / 70.0).abs() < 1e-9);
    }

    #[test]
    fn one_arm_is_decided_by_its_episodes_or_by_its_sign() {
        let one = |episodes, boundary| {
            let sides = [vec![vec![1.0; 3]]];
            Alike::of(&sides, episodes).expect("alike").p(boundary).expect("a p")
        };
        // 288 of 288 against 0.9: z = 0.1 / sqrt(0.09 / 288) = 5.657.
        assert!(one(Some(96), 0.9) < 1e-7);
        assert_eq!(one(None, 0.9), 0.25);
        assert_eq!(one(Some(96), 1.0), 1.0);
    }

    #[test]
    fn a_spread_or_a_single_run_is_not_alike() {
        assert!(Alike::of(&[vec![vec![1.0, 0.9]]], None).is_none());
        assert!(Alike::of(&[vec![vec![1.0]]], None).is_none());
        assert!(Alike::of(&[], None).is_none());
    }
}
