//! Percentile bootstrap of any estimate over stratified samples: runs are resampled with replacement within
//! their stratum (Agarwal et al. 2021). All draws come from one named stream.

use super::Interval;
use super::rank::improvement;
use super::summary::{interquartile_mean, mean, quantile_of_sorted};
use crate::stream::Stream;

/// Number of resamples for an interval. Its ends then vary by less than a hundredth of its width between
/// streams.
pub const RESAMPLES: usize = 10_000;

/// Runs by stratum.
pub type Strata = Vec<Vec<f64>>;

/// The mean over the strata of their means; `None` if a stratum is empty.
pub fn mean_of(strata: &[Vec<f64>]) -> Option<f64> {
    let means: Option<Vec<f64>> = strata.iter().map(|stratum| mean(stratum)).collect();
    mean(&means?)
}

/// The interquartile mean over all runs of all strata; `None` without runs.
pub fn iqm_of(strata: &[Vec<f64>]) -> Option<f64> {
    interquartile_mean(&strata.concat())
}

/// The estimates of all resamples, sorted.
#[derive(Clone, Debug, PartialEq)]
pub struct Draws(Vec<f64>);

impl Draws {
    /// Resamples one or two stratified samples. `None` if a stratum has fewer than two values, or the
    /// estimate does not exist.
    pub fn new(
        sides: &[Strata],
        estimate: &dyn Fn(&[Strata]) -> Option<f64>,
        stream: &mut Stream,
    ) -> Option<Self> {
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
        Some(Self(values))
    }

    /// The percentile interval.
    pub fn interval(&self, confidence: f64) -> Option<Interval> {
        let tail = 0.5 - 0.5 * confidence;
        Some(Interval {
            low: quantile_of_sorted(&self.0, tail)?,
            high: quantile_of_sorted(&self.0, 1.0 - tail)?,
        })
    }

    /// The two-sided p value of the estimate being `boundary`: the level at which the percentile interval
    /// begins to contain it. Twice the smaller share of resamples on either side of the boundary, those on it
    /// counting for both; the sample itself counts as one more resample (Davison and Hinkley 1997, section
    /// 4.4), so the p value is never zero.
    pub fn p(&self, boundary: f64) -> f64 {
        let below = self.0.partition_point(|value| *value < boundary);
        let above = self.0.len() - self.0.partition_point(|value| *value <= boundary);
        let on = self.0.len() - below - above;
        let fewer = below.min(above) + on + 1;
        (2.0 * fewer as f64 / (self.0.len() + 1) as f64).min(1.0)
    }
}

/// The percentile interval of an estimate of one or two stratified samples. `None` if a stratum has fewer
/// than two values, or the estimate does not exist.
pub fn percentile(
    sides: &[Strata],
    estimate: &dyn Fn(&[Strata]) -> Option<f64>,
    confidence: f64,
    stream: &mut Stream,
) -> Option<Interval> {
    Draws::new(sides, estimate, stream)?.interval(confidence)
}

/// The difference between a summary of the first and of the second side, or the summary of a single side.
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
            percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new(name))
                .expect("five runs")
        };
        assert_eq!(interval("test/a"), interval("test/a"));
        let (one, other) = (interval("test/a"), interval("test/b"));
        assert!(
            (one.low - other.low).abs() < 0.01 && (one.high - other.high).abs() < 0.01,
            "{one:?} {other:?}"
        );
    }

    #[test]
    fn a_p_value_is_below_a_level_where_the_interval_of_that_level_leaves_the_boundary_out() {
        let sides = [vec![vec![0.9, 0.4, 0.7, 0.8, 0.6]], vec![vec![0.2, 0.5, 0.1, 0.6, 0.3]]];
        let difference = |sides: &[Strata]| contrast(sides, mean_of);
        let draws = Draws::new(&sides, &difference, &mut Stream::new("test/p")).expect("five runs");
        for boundary in [-0.2, 0.0, 0.1, 0.2, 0.34, 0.5, 0.6] {
            let p = draws.p(boundary);
            for level in [0.9, 0.5, 0.2, 0.05, 0.01] {
                let outside = !draws.interval(1.0 - level).expect("an interval").contains(boundary);
                // Exactly at the level the two may differ by one resample.
                assert!((p < level) == outside || (p - level).abs() < 0.01, "{boundary} {level} {p}");
            }
        }
        assert_eq!(draws.p(-5.0), 2.0 / 10_001.0);
        assert!(draws.p(0.34) > 0.9);
    }

    #[test]
    fn a_stratum_of_one_run_has_no_interval() {
        let sides = [vec![vec![0.9, 0.4], vec![0.1]]];
        assert_eq!(
            percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new("test")),
            None
        );
    }

    #[test]
    fn strata_are_weighed_alike_by_the_mean_and_by_their_runs_by_the_iqm() {
        let strata = vec![vec![1.0, 1.0, 1.0, 1.0], vec![3.0, 5.0]];
        assert_eq!(mean_of(&strata), Some(2.5));
        assert_eq!(iqm_of(&strata), Some(1.5));
        assert_eq!(mean_of(&[vec![], vec![1.0]]), None);
    }
}
