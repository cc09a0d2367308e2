//! The tests of claims applied to samples: estimate, interval and p value.

use super::alike::Alike;
use super::difference::{Pairs, independent};
use super::invert::two_sided;
use super::mean::FEWEST;
use super::proportion::{fisher_exact, mcnemar_exact, score_test, wilson};
use super::resample::{Draws, Strata, contrast, improvement_of, iqm_of, mean_of};
use super::summary::{mean, median};
use super::{Interval, rank, trend, welch};
use crate::kinds::statistic::{FEW, Method, SMALLEST_OF_FEW, Unit};
use crate::spec::claim::Summary;
use crate::stream::Stream;

/// The data of a comparison; the left side of the expectation comes first.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    /// The values of the runs.
    Runs {
        /// By side and stratum.
        sides: Vec<Strata>,
        /// Smallest number of episodes behind a run's value, if that is a share of episodes.
        episodes: Option<usize>,
    },
    /// The values of the episodes of one policy per side, and whether the episodes are paired.
    Episodes {
        /// By side.
        sides: Vec<Vec<f64>>,
        /// Whether both sides ran the same episodes.
        paired: bool,
    },
}

impl Sample {
    /// Runs whose values are not shares of episodes.
    pub fn of_runs(sides: Vec<Strata>) -> Self {
        Self::Runs { sides, episodes: None }
    }
}

/// A test of a claim on one sample.
#[derive(Clone, Copy, Debug)]
pub struct Test<'a> {
    /// The computed quantity.
    pub method: Method,
    /// Summary of the runs.
    pub summary: Summary,
    /// Whether the strata of a side are the points of a trend; then its slope replaces their mean.
    pub trend: bool,
    /// Factor on the second side before it is subtracted from the first.
    pub factor: f64,
    /// Name of the metric; part of the random stream's name.
    pub name: &'a str,
}

/// Result of a test on a sample, whatever it is compared with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Observations of each side.
    pub n: Vec<usize>,
    /// Size of the smallest separate sample: a stratum of runs, or the episodes of a side.
    pub fewest: usize,
    /// The value of each side.
    pub sides: Vec<Option<f64>>,
    /// The number that is compared with the boundary.
    pub value: Option<f64>,
    /// A remark for the reader; may be empty.
    pub remark: String,
}

impl Test<'_> {
    /// The estimate.
    pub fn measure(&self, sample: &Sample) -> Measured {
        let sides = self.sides(sample);
        let n = match sample {
            Sample::Runs { sides, .. } => {
                sides.iter().map(|strata| strata.iter().map(Vec::len).sum()).collect()
            }
            Sample::Episodes { sides, .. } => sides.iter().map(Vec::len).collect(),
        };
        let remark = self.remark(sample).to_owned();
        Measured { n, fewest: fewest(sample), value: self.value(sample), sides, remark }
    }

    /// The value of each side.
    fn sides(&self, sample: &Sample) -> Vec<Option<f64>> {
        match sample {
            Sample::Runs { sides, .. } => sides.iter().map(|strata| self.summarised(strata)).collect(),
            Sample::Episodes { sides, .. } if self.trend => {
                let means = sides.iter().map(|values| mean(values)).collect::<Option<Vec<_>>>();
                vec![means.and_then(|means| trend::slope(&means))]
            }
            Sample::Episodes { sides, .. } => sides.iter().map(|values| mean(values)).collect(),
        }
    }

    fn summarised(&self, strata: &Strata) -> Option<f64> {
        match self.method {
            Method::MannWhitney | Method::ProbabilityOfImprovement => median(&strata.concat()),
            _ if self.trend => {
                trend::slope(&strata.iter().map(|runs| mean(runs)).collect::<Option<Vec<_>>>()?)
            }
            _ => self.summarise()(strata),
        }
    }

    /// The weight of each stratum of a side.
    fn weights(&self, strata: usize) -> Vec<f64> {
        if self.trend { trend::weights(strata) } else { vec![1.0 / strata as f64; strata] }
    }

    /// The difference of two sides, or one side's value, with its t distribution.
    fn student(&self, sides: &[Strata]) -> Option<welch::Estimate> {
        let signs = match sides.len() {
            1 | 2 => [1.0, -1.0],
            _ => return None,
        };
        let mut weighted: Vec<(f64, &[f64])> = Vec::new();
        for (strata, sign) in sides.iter().zip(signs) {
            let weights = self.weights(strata.len());
            weighted
                .extend(weights.iter().zip(strata).map(|(weight, runs)| (sign * weight, runs.as_slice())));
        }
        welch::contrast(&weighted)
    }

    /// The pooled successes and episodes of each point of a trend whose points have no spread between runs.
    fn pooled(&self, sample: &Sample) -> Option<Vec<[u64; 2]>> {
        let Sample::Runs { sides, episodes: Some(episodes) } = sample else { return None };
        let [strata] = sides.as_slice() else { return None };
        self.alike(sample).filter(|_| self.trend)?;
        let count = |runs: &Vec<f64>| {
            let trials = (runs.len() * episodes) as u64;
            [libm::round(runs[0] * trials as f64) as u64, trials]
        };
        Some(strata.iter().map(count).collect())
    }

    fn summarise(&self) -> fn(&[Vec<f64>]) -> Option<f64> {
        if self.summary == Summary::Iqm { iqm_of } else { mean_of }
    }

    fn value(&self, sample: &Sample) -> Option<f64> {
        let scaled = self.scaled(sample);
        match (self.method, &scaled) {
            (Method::MannWhitney, Sample::Runs { .. }) => {
                let [first, second] = runs(&scaled)?;
                rank::shift(&first, &second)
            }
            (Method::ProbabilityOfImprovement, Sample::Runs { sides, .. }) => improvement_of(sides),
            _ => match self.sides(&scaled).as_slice() {
                [one] => *one,
                [first, second] => Some((*first)? - (*second)?),
                _ => None,
            },
        }
    }

    /// The sample with the second side multiplied by the factor.
    fn scaled(&self, sample: &Sample) -> Sample {
        let mut sample = sample.clone();
        if self.factor != 1.0 {
            match &mut sample {
                Sample::Runs { sides, .. } => {
                    sides.iter_mut().skip(1).flatten().flatten().for_each(|value| *value *= self.factor);
                }
                Sample::Episodes { sides, .. } => {
                    sides.iter_mut().skip(1).flatten().for_each(|value| *value *= self.factor);
                }
            }
        }
        sample
    }

    /// The estimates of the resamples, if the test is a bootstrap and the sample is large enough.
    fn draws(&self, sample: &Sample) -> Option<Draws> {
        let mut stream = Stream::new(&format!("report/bootstrap/{}", self.name));
        match (self.method, sample) {
            (Method::StratifiedBootstrap, Sample::Runs { sides, .. }) => {
                let summary = self.summarise();
                Draws::new(sides, &|sides| contrast(sides, summary), &mut stream)
            }
            (Method::ProbabilityOfImprovement, Sample::Runs { sides, .. }) => {
                Draws::new(sides, &improvement_of, &mut stream)
            }
            (Method::EpisodeBootstrap, Sample::Episodes { sides, paired }) => {
                let strata: Vec<Strata> = match (sides.as_slice(), paired) {
                    ([first, second], true) => {
                        vec![vec![first.iter().zip(second).map(|(a, b)| a - b).collect()]]
                    }
                    _ => sides.iter().map(|values| vec![values.clone()]).collect(),
                };
                Draws::new(&strata, &|sides| contrast(sides, mean_of), &mut stream)
            }
            _ => None,
        }
    }

    /// The interval with this confidence; `None` if the sample does not allow one.
    pub fn interval(&self, sample: &Sample, confidence: f64) -> Option<Interval> {
        let scaled = self.scaled(sample);
        match (self.method, &scaled) {
            (
                Method::StratifiedBootstrap | Method::ProbabilityOfImprovement | Method::EpisodeBootstrap,
                _,
            ) => self.draws(&scaled)?.interval(confidence),
            (Method::Welch, Sample::Runs { sides, .. }) => match self.pooled(&scaled) {
                Some(counts) => trend::of_shares(&counts, confidence),
                None => self.student(sides)?.interval(confidence),
            },
            (Method::MannWhitney, Sample::Runs { .. }) => {
                let [first, second] = runs(&scaled)?;
                rank::shift_interval(&first, &second, confidence)
            }
            (Method::Mcnemar, Sample::Episodes { sides, paired: true }) => {
                Some(pairs(sides)?.difference(confidence).1)
            }
            (Method::Newcombe, Sample::Episodes { sides, .. }) if self.trend => {
                trend::of_shares(&sides.iter().map(|values| count(values)).collect::<Vec<_>>(), confidence)
            }
            (Method::Newcombe, Sample::Episodes { sides, .. }) => {
                let [first, second] = counts(sides)?;
                Some(independent(first, second, confidence).1)
            }
            (Method::Wilson, Sample::Episodes { sides, .. }) => {
                let [successes, trials] = count(sides.first()?);
                Some(wilson(successes, trials, confidence))
            }
            _ => None,
        }
    }

    /// Two-sided p value of the estimate being `boundary`; `None` if the sample does not allow one. For few
    /// runs it is at least [`SMALLEST_OF_FEW`].
    pub fn p(&self, sample: &Sample, boundary: f64) -> Option<f64> {
        let p = self.exact_p(&self.scaled(sample), boundary)?;
        let is_of_few = self.method.unit() == Unit::Seed && fewest(sample) < FEW;
        Some(if is_of_few { p.max(SMALLEST_OF_FEW) } else { p })
    }

    /// The p value of a sample whose second side has been multiplied by the factor.
    fn exact_p(&self, sample: &Sample, boundary: f64) -> Option<f64> {
        if let Some(counts) = self.pooled(sample) {
            return two_sided(self.value(sample)?, boundary, &|confidence| {
                trend::of_shares(&counts, confidence)
            });
        }
        if let Some(alike) = self.alike(sample) {
            return if self.trend { None } else { alike.p(boundary) };
        }
        match (self.method, sample) {
            (Method::Welch, Sample::Runs { sides, .. }) => self.student(sides)?.p(boundary),
            (Method::MannWhitney, _) => order(runs(sample)?, boundary),
            // Percentile intervals of samples that do not overlap have no width; their order still has a p
            // value.
            (Method::ProbabilityOfImprovement, Sample::Runs { sides, .. }) => {
                let drawn = self.draws(sample)?.p(boundary);
                let ordered = if sides.iter().all(|strata| strata.len() == 1) && boundary == 0.5 {
                    order(runs(sample)?, 0.0)?
                } else {
                    0.0
                };
                Some(drawn.max(ordered))
            }
            (Method::EpisodeBootstrap, _) if fewest(sample) < FEWEST => None,
            (Method::StratifiedBootstrap | Method::EpisodeBootstrap, _) => {
                Some(self.draws(sample)?.p(boundary))
            }
            (Method::Wilson, Sample::Episodes { sides, .. }) => {
                let [successes, trials] = count(sides.first()?);
                let is_at_the_boundary = trials > 0 && successes as f64 == boundary * trials as f64;
                match score_test(successes, trials, boundary) {
                    // An expected share of 0 or 1 is refuted by a single episode.
                    None => (trials > 0).then_some(if is_at_the_boundary { 1.0 } else { 0.0 }),
                    p => p,
                }
            }
            (Method::Mcnemar, Sample::Episodes { sides, paired: true }) if boundary == 0.0 => {
                pairs(sides).map(|pairs| mcnemar_exact(pairs.only_first, pairs.only_second))
            }
            (Method::Newcombe, Sample::Episodes { sides, .. }) if boundary == 0.0 && !self.trend => {
                counts(sides).map(|[first, second]| fisher_exact(first, second))
            }
            (Method::Mcnemar | Method::Newcombe, Sample::Episodes { .. }) => {
                two_sided(self.value(sample)?, boundary, &|confidence| self.interval(sample, confidence))
            }
            _ => None,
        }
    }

    /// A remark on the sample.
    fn remark(&self, sample: &Sample) -> &'static str {
        match (self.method, sample) {
            (Method::Mcnemar, Sample::Episodes { paired: false, .. }) => {
                "the arms did not run the same episodes"
            }
            _ => match self.alike(sample) {
                None => "",
                Some(_) if self.pooled(sample).is_some() => {
                    "the runs of each point are all alike: their episodes decide, pooled"
                }
                Some(_) if self.trend => "the runs of each point are all alike: nothing decides",
                Some(Alike { sides: [_], episodes: Some(_) }) => {
                    "all runs are alike: their episodes decide, pooled"
                }
                Some(Alike { sides: [_], .. }) => "all runs are alike: the sign test decides",
                Some(alike) if alike.is_of_one_share() => {
                    "all runs of both arms are alike: against a margin their episodes decide, pooled"
                }
                Some(_) => "the runs of each arm are all alike: Fisher's exact test over the runs decides",
            },
        }
    }

    /// The sample of a mean over runs if they have no spread.
    fn alike<'s>(&self, sample: &'s Sample) -> Option<Alike<'s>> {
        match (self.method, sample) {
            (Method::Welch | Method::StratifiedBootstrap, Sample::Runs { sides, episodes }) => {
                Alike::of(sides, *episodes)
            }
            _ => None,
        }
    }
}

/// The p value for the order of the runs, with the first side shifted by the boundary.
fn order([first, second]: [Vec<f64>; 2], boundary: f64) -> Option<f64> {
    let moved: Vec<f64> = first.iter().map(|value| value - boundary).collect();
    rank::mann_whitney(&moved, &second)
}

/// Size of the smallest separate sample.
fn fewest(sample: &Sample) -> usize {
    let sizes = match sample {
        Sample::Runs { sides, .. } => sides.iter().flatten().map(Vec::len).min(),
        Sample::Episodes { sides, .. } => sides.iter().map(Vec::len).min(),
    };
    sizes.unwrap_or(0)
}

/// The runs of two sides; `None` if there are not two, or one is empty.
fn runs(sample: &Sample) -> Option<[Vec<f64>; 2]> {
    let Sample::Runs { sides, .. } = sample else { return None };
    let [first, second] = sides.as_slice() else { return None };
    let both = [first.concat(), second.concat()];
    both.iter().all(|side| !side.is_empty()).then_some(both)
}

/// Successes and trials.
pub fn count(values: &[f64]) -> [u64; 2] {
    [values.iter().filter(|value| **value > 0.5).count() as u64, values.len() as u64]
}

fn counts(sides: &[Vec<f64>]) -> Option<[[u64; 2]; 2]> {
    let [first, second] = sides else { return None };
    Some([count(first), count(second)])
}

/// Outcomes of the same episodes on two sides.
pub fn pairs(sides: &[Vec<f64>]) -> Option<Pairs> {
    let [first, second] = sides else { return None };
    let successes = |values: &Vec<f64>| values.iter().map(|value| *value > 0.5).collect::<Vec<bool>>();
    Some(Pairs::count(&successes(first), &successes(second)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn welch_test(factor: f64) -> Test<'static> {
        Test { method: Method::Welch, summary: Summary::Mean, trend: false, factor, name: "test" }
    }

    fn of(first: &[f64], second: &[f64]) -> Sample {
        Sample::of_runs(vec![vec![first.to_vec()], vec![second.to_vec()]])
    }

    #[test]
    fn few_runs_have_no_p_below_two_in_a_thousand() {
        let apart = |runs: usize| {
            let first: Vec<f64> = (0..runs).map(|run| 100.0 + run as f64).collect();
            let second: Vec<f64> = (0..runs).map(|run| run as f64).collect();
            welch_test(1.0).p(&of(&first, &second), 0.0).expect("a p")
        };
        assert_eq!([2, 3, 4].map(apart), [SMALLEST_OF_FEW; 3]);
        assert!(apart(5) < 1e-6);
    }

    #[test]
    fn a_factor_multiplies_the_second_arm() {
        let sample = of(&[1.0, 2.0, 3.0, 4.0, 5.0], &[7.0, 8.0, 9.0, 10.0, 11.0]);
        let halved = welch_test(0.5);
        assert_eq!(halved.measure(&sample).value, Some(3.0 - 4.5));
        assert_eq!(halved.measure(&sample).sides, [Some(3.0), Some(9.0)], "the sides are shown as measured");
        let direct = welch::two(&[1.0, 2.0, 3.0, 4.0, 5.0], &[3.5, 4.0, 4.5, 5.0, 5.5]).expect("spread");
        assert_eq!(halved.p(&sample, 0.0), direct.p(0.0));
        assert_eq!(halved.interval(&sample, 0.95), direct.interval(0.95));
    }

    #[test]
    fn a_trend_is_the_slope_of_the_means_and_of_runs_that_are_alike_that_of_their_episodes() {
        let trend = Test { trend: true, ..welch_test(1.0) };
        let points = |points: &[[f64; 2]], episodes| Sample::Runs {
            sides: vec![points.iter().map(|runs| runs.to_vec()).collect()],
            episodes,
        };
        let rising = points(&[[0.58, 0.62], [0.70, 0.74], [0.86, 0.9], [0.86, 0.9], [0.98, 1.0]], Some(150));
        let value = trend.measure(&rising).value.expect("a slope");
        assert!((value - 0.094).abs() < 1e-12, "{value}");
        assert!(trend.p(&rising, 0.025).is_some_and(|p| p <= 0.01) && trend.p(&rising, value) == Some(1.0));
        let level = points(&[[1.0; 2]; 5], Some(150));
        assert_eq!(trend.measure(&level).value, Some(0.0));
        assert!(trend.p(&level, 0.025).is_some_and(|p| p <= 0.01), "no slope where all survive");
        assert_eq!(trend.p(&points(&[[1.0; 2]; 5], None), 0.025), None);
        // One policy at each point: its episodes.
        let of_policies = Test { method: Method::Newcombe, ..trend };
        let alive =
            |count: usize| (0..150).map(|episode| f64::from(u8::from(episode < count))).collect::<Vec<f64>>();
        let episodes =
            |counts: [usize; 5]| Sample::Episodes { sides: counts.map(alive).to_vec(), paired: false };
        let rising = episodes([90, 108, 132, 132, 150]);
        let measured = of_policies.measure(&rising);
        assert!(measured.value.is_some_and(|value| (value - 0.096).abs() < 1e-12), "{measured:?}");
        assert_eq!((measured.n, measured.sides.len()), (vec![150; 5], 1));
        assert!(of_policies.p(&rising, 0.025).is_some_and(|p| p < 1e-6));
        // By hand: 0.2236 z^2 / (150 + z^2) = 0.025 at z = 4.345.
        assert!(of_policies.p(&episodes([150; 5]), 0.025).is_some_and(|p| (p - 1.39e-5).abs() < 2e-7));
    }

    #[test]
    fn a_mean_over_strata_takes_the_difference_between_them_out() {
        let strata = |shift: f64| {
            vec![vec![1.0 + shift, 1.1 + shift, 1.2 + shift], vec![9.0 + shift, 9.1 + shift, 9.3 + shift]]
        };
        let sample = Sample::of_runs(vec![strata(0.5), strata(0.0)]);
        let interval = welch_test(1.0).interval(&sample, 0.95).expect("an interval");
        assert!(interval.low > 0.2 && interval.high < 0.8, "{interval:?}");
    }

    #[test]
    fn a_share_of_one_is_refuted_by_one_episode() {
        let wilson =
            Test { method: Method::Wilson, summary: Summary::Mean, trend: false, factor: 1.0, name: "test" };
        let sample = |successes: usize| Sample::Episodes {
            sides: vec![(0..20).map(|at| f64::from(u8::from(at < successes))).collect()],
            paired: false,
        };
        assert_eq!((wilson.p(&sample(20), 1.0), wilson.p(&sample(19), 1.0)), (Some(1.0), Some(0.0)));
    }

    #[test]
    fn the_p_value_of_a_margin_of_paired_episodes_is_that_of_their_interval() {
        let mcnemar =
            Test { method: Method::Mcnemar, summary: Summary::Mean, trend: false, factor: 1.0, name: "test" };
        let side =
            |successes: usize| (0..40).map(|at| f64::from(u8::from(at < successes))).collect::<Vec<f64>>();
        let sample = Sample::Episodes { sides: vec![side(38), side(20)], paired: true };
        let p = mcnemar.p(&sample, 0.3).expect("a p");
        let interval = mcnemar.interval(&sample, 1.0 - p).expect("an interval");
        assert!((interval.low - 0.3).abs() < 1e-6, "{p} {interval:?}");
    }
}
