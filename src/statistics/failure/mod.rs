//! Why some parameter sets fail: direction of failure, logistic regression, failure rates per decile,
//! standardised mean differences.
//!
//! A set is a row of factors around nominal values, tried by one or several policies. Intervals come from
//! resampling the sets: the outcomes of all policies on a set are resampled together. Independent of robots
//! and reports.

pub mod deciles;
pub mod difference;
pub mod loadings;
pub mod logistic;

use super::Interval;
use super::summary::quantile_of_sorted;
use crate::stream::Stream;

/// Number of resamples for the intervals: fewer than elsewhere, because each fits a regression.
pub const RESAMPLES: usize = 400;
/// Smallest number of failures, and of survivals, for an analysis.
pub const FEWEST: f64 = 10.0;

/// Parameter sets and their outcomes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sets {
    /// The parameters.
    pub names: Vec<String>,
    /// A row for each set: for each parameter the deviation from its nominal value in units of half its
    /// range, -1 to 1.
    pub rows: Vec<Vec<f64>>,
    /// How many policies failed, by set.
    pub failures: Vec<f64>,
    /// How many policies tried it, by set.
    pub trials: Vec<f64>,
}

/// A number with its bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranged {
    /// The number.
    pub value: f64,
    /// Its 95 % interval; missing if at least a quarter of the resamples did not yield the number.
    pub interval: Option<Interval>,
}

/// Results, with a number for each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Entries of the direction of failure, see [`loadings`].
    pub loadings: Vec<Ranged>,
    /// Share of the squared deviations of failed sets along that direction; one divided by the number of
    /// parameters without a direction.
    pub share: f64,
    /// Change of the log odds of failure per standard deviation of the parameter.
    pub linear: Vec<Ranged>,
    /// Change of the log odds of failure per standard deviation of its square.
    pub quadratic: Vec<Ranged>,
    /// The penalty of the regression, needed if failures and survivals are perfectly separable.
    pub ridge: Option<f64>,
    /// Standardised mean differences, failed minus survived.
    pub differences: Vec<Ranged>,
}

/// One estimate of all results, without intervals.
struct Draw {
    loadings: loadings::Loadings,
    fit: logistic::Fit,
    differences: Vec<f64>,
}

impl Sets {
    /// Numbers of failures and of trials.
    pub fn counts(&self) -> [f64; 2] {
        [self.failures.iter().sum(), self.trials.iter().sum()]
    }

    /// All results with intervals; `None` with fewer than [`FEWEST`] failures or survivals, or if no
    /// parameter varies.
    pub fn analyse(&self, confidence: f64, stream: &mut Stream) -> Option<Analysis> {
        let [failed, tried] = self.counts();
        if failed < FEWEST || tried - failed < FEWEST || self.names.is_empty() {
            return None;
        }
        let design = logistic::Design::new(self);
        let whole = self.draw(&design, &vec![1.0; self.rows.len()], None)?;
        let mut draws = Vec::with_capacity(RESAMPLES);
        for _ in 0..RESAMPLES {
            let mut weights = vec![0.0; self.rows.len()];
            (0..weights.len()).for_each(|_| weights[stream.below(self.rows.len())] += 1.0);
            draws.extend(self.draw(&design, &weights, Some(&whole)));
        }
        let ranged = |value: f64, of: &dyn Fn(&Draw) -> f64| Ranged {
            value,
            interval: spread(&draws, of, confidence),
        };
        let each = |of: &dyn Fn(&Draw, usize) -> f64| -> Vec<Ranged> {
            (0..self.names.len()).map(|at| ranged(of(&whole, at), &|draw| of(draw, at))).collect()
        };
        Some(Analysis {
            loadings: each(&|draw, at| draw.loadings.direction[at]),
            share: whole.loadings.share,
            linear: each(&|draw, at| draw.fit.linear[at]),
            quadratic: each(&|draw, at| draw.fit.quadratic[at]),
            ridge: whole.fit.ridge,
            differences: each(&|draw, at| draw.differences[at]),
        })
    }

    /// The estimates with weighted sets; directions have the sign of those of `like`.
    fn draw(&self, design: &logistic::Design, weights: &[f64], like: Option<&Draw>) -> Option<Draw> {
        let mut loadings = loadings::of(self, weights)?;
        if let Some(like) = like {
            loadings.turn_like(&like.loadings);
        }
        let fit = design.fit(weights, like.map(|like| &like.fit))?;
        Some(Draw { loadings, fit, differences: difference::of(self, weights)? })
    }
}

fn spread(draws: &[Draw], of: &dyn Fn(&Draw) -> f64, confidence: f64) -> Option<Interval> {
    if 4 * draws.len() <= 3 * RESAMPLES {
        return None;
    }
    let mut values: Vec<f64> = draws.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    let tail = 0.5 - 0.5 * confidence;
    Some(Interval { low: quantile_of_sorted(&values, tail)?, high: quantile_of_sorted(&values, 1.0 - tail)? })
}
