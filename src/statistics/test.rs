//! The tests of claims applied to samples: estimate, interval and p value.

use super::difference::{Pairs, independent};
use super::mean::FEWEST;
use super::proportion::{fisher_exact, mcnemar_exact, score_test, wilson};
use super::resample::{Draws, Strata, contrast, improvement_of, iqm_of, mean_of};
use super::summary::{mean, median};
use super::{Interval, rank, welch};
use crate::kinds::statistic::Method;
use crate::spec::claim::Summary;
use crate::stream::Stream;

/// What a comparison is computed from; the left side of the expectation comes first.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    /// The values of the runs, by side and stratum.
    Runs(Vec<Strata>),
    /// The values of the episodes of one policy a side, and whether the episodes are the same.
    Episodes {
        /// By side.
        sides: Vec<Vec<f64>>,
        /// Whether both sides ran the same episodes.
        paired: bool,
    },
}

/// A test of a claim on one sample.
#[derive(Clone, Copy, Debug)]
pub struct Test<'a> {
    /// What is computed.
    pub method: Method,
    /// What runs are summarised by.
    pub summary: Summary,
    /// What the estimate is compared with: 0, the claim's number, or one half, moved by the margin.
    pub boundary: f64,
    /// What is measured; names the random stream.
    pub name: &'a str,
}

/// What a test says, apart from its interval.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Observations of each side.
    pub n: Vec<usize>,
    /// Those of the smallest sample that is resampled by itself: a stratum of runs, or the episodes of a side.
    pub fewest: usize,
    /// The value of each side.
    pub sides: Vec<Option<f64>>,
    /// What is compared with the boundary.
    pub value: Option<f64>,
    /// Two-sided p value.
    pub p: Option<f64>,
    /// What must be known of it; may be empty.
    pub remark: String,
}

impl Test<'_> {
    /// Estimate and p value.
    pub fn measure(&self, sample: &Sample) -> Measured {
        let sides = self.sides(sample);
        let n = match sample {
            Sample::Runs(sides) => sides.iter().map(|strata| strata.iter().map(Vec::len).sum()).collect(),
            Sample::Episodes { sides, .. } => sides.iter().map(Vec::len).collect(),
        };
        let (p, remark) = self.p(sample);
        Measured { n, fewest: fewest(sample), value: self.value(sample, &sides), sides, p, remark }
    }

    /// The value of each side by itself.
    fn sides(&self, sample: &Sample) -> Vec<Option<f64>> {
        match sample {
            Sample::Runs(sides) => {
                let of = |strata: &Strata| match self.method {
                    Method::MannWhitney | Method::ProbabilityOfImprovement => median(&strata.concat()),
                    _ => self.summarise()(strata),
                };
                sides.iter().map(of).collect()
            }
            Sample::Episodes { sides, .. } => sides.iter().map(|values| mean(values)).collect(),
        }
    }

    fn summarise(&self) -> fn(&[Vec<f64>]) -> Option<f64> {
        if self.summary == Summary::Iqm { iqm_of } else { mean_of }
    }

    fn value(&self, sample: &Sample, sides: &[Option<f64>]) -> Option<f64> {
        match (self.method, sample) {
            (Method::MannWhitney, Sample::Runs(_)) => {
                let [first, second] = runs(sample)?;
                rank::shift(&first, &second)
            }
            (Method::ProbabilityOfImprovement, Sample::Runs(sides)) => improvement_of(sides),
            _ => match sides {
                [one] => *one,
                [first, second] => Some((*first)? - (*second)?),
                _ => None,
            },
        }
    }

    /// The estimates of the resamples, where the test is a bootstrap and the sample is large enough.
    fn draws(&self, sample: &Sample) -> Option<Draws> {
        let mut stream = Stream::new(&format!("report/bootstrap/{}", self.name));
        match (self.method, sample) {
            (Method::StratifiedBootstrap, Sample::Runs(sides)) => {
                let summary = self.summarise();
                Draws::new(sides, &|sides| contrast(sides, summary), &mut stream)
            }
            (Method::ProbabilityOfImprovement, Sample::Runs(sides)) => Draws::new(sides, &improvement_of, &mut stream),
            (Method::EpisodeBootstrap, Sample::Episodes { sides, paired }) => {
                let strata: Vec<Strata> = match (sides.as_slice(), paired) {
                    ([first, second], true) => vec![vec![first.iter().zip(second).map(|(a, b)| a - b).collect()]],
                    _ => sides.iter().map(|values| vec![values.clone()]).collect(),
                };
                Draws::new(&strata, &|sides| contrast(sides, mean_of), &mut stream)
            }
            _ => None,
        }
    }

    /// The interval of this confidence; `None` when the sample gives none.
    pub fn interval(&self, sample: &Sample, confidence: f64) -> Option<Interval> {
        match (self.method, sample) {
            (Method::StratifiedBootstrap | Method::ProbabilityOfImprovement | Method::EpisodeBootstrap, _) => {
                self.draws(sample)?.interval(confidence)
            }
            (Method::Welch, Sample::Runs(_)) => self.student(sample)?.interval(confidence),
            (Method::MannWhitney, Sample::Runs(_)) => {
                let [first, second] = runs(sample)?;
                rank::shift_interval(&first, &second, confidence)
            }
            (Method::Mcnemar, Sample::Episodes { sides, paired: true }) => Some(pairs(sides)?.difference(confidence).1),
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

    /// The p value, where the test has one, and a remark.
    fn p(&self, sample: &Sample) -> (Option<f64>, String) {
        let none = |remark: &str| (None, remark.to_owned());
        match (self.method, sample) {
            (Method::Welch, _) => match self.student(sample) {
                Some(estimate) => (estimate.p(self.boundary), String::new()),
                None => none("the runs have no spread, or are too few, so there is no interval"),
            },
            (Method::MannWhitney, _) => match runs(sample) {
                Some(sides) => (self.order(sides), String::new()),
                None => none(""),
            },
            (Method::StratifiedBootstrap, Sample::Runs(sides)) if without_spread(sides) => {
                let alike = "the runs of each arm are all alike";
                let single = sides.iter().all(|strata| strata.len() == 1);
                match runs(sample).filter(|_| single).and_then(|sides| self.order(sides)) {
                    Some(p) => (Some(p), format!("{alike}: their order decides, not the interval")),
                    None => (None, format!("{alike}, so the interval has no width")),
                }
            }
            // Of few values the p of a percentile bootstrap says how few they are, not how sure one can be.
            (Method::StratifiedBootstrap | Method::ProbabilityOfImprovement | Method::EpisodeBootstrap, _) => {
                let draws = if fewest(sample) < FEWEST { None } else { self.draws(sample) };
                (draws.map(|draws| draws.p(self.boundary)), String::new())
            }
            (Method::Wilson, Sample::Episodes { sides, .. }) => {
                let counted = sides.first().map(|values| count(values));
                (counted.and_then(|[successes, trials]| score_test(successes, trials, self.boundary)), String::new())
            }
            (Method::Mcnemar, Sample::Episodes { sides, paired: true }) => {
                (pairs(sides).map(|pairs| mcnemar_exact(pairs.only_first, pairs.only_second)), String::new())
            }
            (Method::Mcnemar, _) => none("the arms did not run the same episodes"),
            (Method::Newcombe, Sample::Episodes { sides, .. }) => {
                (counts(sides).map(|[first, second]| fisher_exact(first, second)), String::new())
            }
            _ => none(""),
        }
    }

    /// The p value of the order of the runs, the first side moved by the boundary.
    fn order(&self, [first, second]: [Vec<f64>; 2]) -> Option<f64> {
        let moved: Vec<f64> = first.iter().map(|value| value - self.boundary).collect();
        rank::mann_whitney(&moved, &second)
    }

    fn student(&self, sample: &Sample) -> Option<welch::Estimate> {
        let Sample::Runs(sides) = sample else { return None };
        match sides.as_slice() {
            [one] => welch::one(&one.concat()),
            [first, second] => welch::two(&first.concat(), &second.concat()),
            _ => None,
        }
    }
}

/// The size of the smallest sample that is resampled by itself.
fn fewest(sample: &Sample) -> usize {
    let sizes = match sample {
        Sample::Runs(sides) => sides.iter().flatten().map(Vec::len).min(),
        Sample::Episodes { sides, .. } => sides.iter().map(Vec::len).min(),
    };
    sizes.unwrap_or(0)
}

/// The runs of two sides; `None` when there are not two, or one is empty.
fn runs(sample: &Sample) -> Option<[Vec<f64>; 2]> {
    let Sample::Runs(sides) = sample else { return None };
    let [first, second] = sides.as_slice() else { return None };
    let both = [first.concat(), second.concat()];
    both.iter().all(|side| !side.is_empty()).then_some(both)
}

/// Whether every stratum has runs that are all alike.
fn without_spread(sides: &[Strata]) -> bool {
    sides.iter().flatten().all(|runs| runs.len() > 1 && runs.iter().all(|run| *run == runs[0]))
}

/// Successes and trials.
fn count(values: &[f64]) -> [u64; 2] {
    [values.iter().filter(|value| **value > 0.5).count() as u64, values.len() as u64]
}

fn counts(sides: &[Vec<f64>]) -> Option<[[u64; 2]; 2]> {
    let [first, second] = sides else { return None };
    Some([count(first), count(second)])
}

fn pairs(sides: &[Vec<f64>]) -> Option<Pairs> {
    let [first, second] = sides else { return None };
    let successes = |values: &Vec<f64>| values.iter().map(|value| *value > 0.5).collect::<Vec<bool>>();
    Some(Pairs::count(&successes(first), &successes(second)))
}
