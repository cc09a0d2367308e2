//! Percentile bootstrap of any estimate over stratified samples: runs are resampled with replacement inside their
//! stratum (Agarwal et al. 2021). All draws come from one named stream.

use super::Interval;
use super::rank::improvement;
use super::summary::{interquartile_mean, mean, quantile_of_sorted};
use crate::stream::Stream;

/// Resamples behind the interval of a claim. The ends then wander by less than a hundredth of the interval's width when
/// the stream changes.
pub const RESAMPLES: usize = 10_000;

/// Runs by stratum.
pub type Strata = Vec<Vec<f64>>;

/// The mean over the strata of their means; `None` when a stratum is empty.
pub fn mean_of(strata: &[Vec<f64>]) -> Option<f64> {
    let means: Option<Vec<f64>> = strata.iter().map(|stratum| mean(stratum)).collect();
    mean(&means?)
}

/// The interquartile mean over all runs of all strata; `None` without runs.
pub fn iqm_of(strata: &[Vec<f64>]) -> Option<f64> {
    interquartile_mean(&strata.concat())
}

/// The percentile interval of an estimate of one or two stratified samples. `None` when a stratum has fewer than two
/// values, or the estimate does not exist.
pub fn percentile(
    sides: &[Strata],
    estimate: &dyn Fn(&[Strata]) -> Option<f64>,
    confidence: f64,
    stream: &mut Stream,
) -> Option<Interval> {
    let strata = || sides.iter().flatten();
    if strata().next().is_none() || strata().any(|stratum| stratum.len() < 2) {
        return None;
    }
    let mut drawn = sides.to_vec();
    let mut values = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        let targets = drawn.iter_mut().flatten();
        for (target, source) in targets.zip(strata()) {
            target.iter_mut().for_each(|value| *value = source[stream.below(source.len())]);
        }
        values.push(estimate(&drawn)?);
    }
    values.sort_by(f64::total_cmp);
    let tail = 0.5 - 0.5 * confidence;
    Some(Interval { low: quantile_of_sorted(&values, tail)?, high: quantile_of_sorted(&values, 1.0 - tail)? })
}

/// The difference of a summary of the first and of the second side, or the summary of the only side.
pub fn contrast(sides: &[Strata], summary: fn(&[Vec<f64>]) -> Option<f64>) -> Option<f64> {
    match sides {
        [one] => summary(one),
        [first, second] => Some(summary(first)? - summary(second)?),
        _ => None,
    }
}

/// The mean over the strata of the probability of improvement of the first side over the second.
pub fn improvement_of(sides: &[Strata]) -> Option<f64> {
    let [first, second] = sides else { return None };
    let each: Option<Vec<f64>> = first.iter().zip(second).map(|(x, y)| improvement(x, y)).collect();
    mean(&each?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_stream_gives_the_same_interval_and_another_nearly_so() {
        let sides = [vec![vec![0.9, 0.4, 0.7, 0.8, 0.6]], vec![vec![0.2, 0.5, 0.1, 0.6, 0.3]]];
        let interval = |name: &str| {
            percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new(name)).expect("five runs")
        };
        assert_eq!(interval("test/a"), interval("test/a"));
        let (one, other) = (interval("test/a"), interval("test/b"));
        assert!((one.low - other.low).abs() < 0.01 && (one.high - other.high).abs() < 0.01, "{one:?} {other:?}");
    }

    #[test]
    fn a_stratum_of_one_run_has_no_interval() {
        let sides = [vec![vec![0.9, 0.4], vec![0.1]]];
        assert_eq!(percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new("test")), None);
    }

    #[test]
    fn strata_are_weighed_alike_by_the_mean_and_by_their_runs_by_the_iqm() {
        let strata = vec![vec![1.0, 1.0, 1.0, 1.0], vec![3.0, 5.0]];
        assert_eq!(mean_of(&strata), Some(2.5));
        assert_eq!(iqm_of(&strata), Some(1.5));
        assert_eq!(mean_of(&[vec![], vec![1.0]]), None);
    }
}
