//! The difference of two policies: paired where their episodes share random streams.

use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::metric::Metric;
use crate::outcome::Evaluation;
use crate::statistics::difference::{Pairs, independent};
use crate::statistics::mean::bootstrap;
use crate::statistics::proportion::{fisher_exact, mcnemar_exact};
use crate::statistics::{CONFIDENCE, Interval, summary};
use crate::stream::Stream;

/// The difference of one metric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// The metric's name.
    pub metric: String,
    /// Its name in tables.
    pub label: String,
    /// First policy minus second.
    pub difference: Estimate,
    /// Two-sided p of the exact test, for survival.
    pub p: Option<f64>,
    /// Whether the interval excludes zero.
    pub established: bool,
}

/// Whether two evaluations ran the same episodes (same random streams in the same order).
pub fn are_paired(first: &Evaluation, second: &Evaluation) -> bool {
    let streams = |evaluation: &Evaluation| -> Vec<String> {
        evaluation.episodes.iter().map(|episode| episode.stream.clone()).collect()
    };
    !first.episodes.is_empty() && streams(first) == streams(second)
}

/// The differences in the metrics that suit the task, first policy minus second.
pub fn differences(first: &Evaluation, second: &Evaluation, task: &str) -> Vec<Difference> {
    if first.episodes.is_empty() || second.episodes.is_empty() {
        return Vec::new();
    }
    Metric::tabled()
        .filter(|metric| metric.is_measured(first) && metric.is_measured(second))
        .filter(|metric| metric.suits(task) && !["left_support", "right_support"].contains(&metric.name))
        .map(|metric| {
            let survival = metric.name == "survival";
            let (difference, p) = if survival {
                survival_difference(first, second)
            } else {
                (mean_difference(&metric, first, second), None)
            };
            let established = difference.interval().is_some_and(|ends| !ends.contains(0.0));
            let difference = if established { told_from_zero(difference) } else { difference };
            Difference { metric: metric.name.into(), label: metric.label.into(), difference, p, established }
        })
        .collect()
}

/// Extra digits that an interval end near zero may need.
const MORE_DIGITS: usize = 3;

/// Adds digits so that an interval that excludes zero is not printed as `[0, 0]`.
fn told_from_zero(difference: Estimate) -> Estimate {
    let scale = if difference.unit == "%" { 100.0 } else { 1.0 };
    let nearest = difference.interval().map_or(0.0, |ends| scale * ends.low.abs().min(ends.high.abs()));
    let own = difference.digits;
    let reads_zero = |digits: &usize| nearest < 0.5 * libm::pow(10.0, -(*digits as f64));
    let digits = (own..own + MORE_DIGITS).find(|digits| !reads_zero(digits)).unwrap_or(own + MORE_DIGITS);
    Estimate { digits, ..difference }
}

fn survival_difference(first: &Evaluation, second: &Evaluation) -> (Estimate, Option<f64>) {
    let outcomes = |evaluation: &Evaluation| -> Vec<bool> {
        evaluation.episodes.iter().map(|episode| episode.survived).collect()
    };
    let (a, b) = (outcomes(first), outcomes(second));
    let ((value, interval), p) = if are_paired(first, second) {
        let pairs = Pairs::count(&a, &b);
        (pairs.difference(CONFIDENCE), mcnemar_exact(pairs.only_first, pairs.only_second))
    } else {
        let count =
            |outcomes: &[bool]| [outcomes.iter().filter(|x| **x).count() as u64, outcomes.len() as u64];
        (independent(count(&a), count(&b), CONFIDENCE), fisher_exact(count(&a), count(&b)))
    };
    let n = Some(a.len().min(b.len()));
    let estimate = Estimate { value: Some(value), n, unit: "%".into(), ..Estimate::default() };
    (estimate.within(Some(interval)), Some(p))
}

fn mean_difference(metric: &Metric, first: &Evaluation, second: &Evaluation) -> Estimate {
    let (a, b) = (metric.values(first), metric.values(second));
    if are_paired(first, second) {
        let pairs: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        return Estimate::mean(&pairs, metric.unit, metric.digits, metric.name);
    }
    let value = summary::mean(&a).zip(summary::mean(&b)).map(|(a, b)| a - b);
    let estimate =
        Estimate { n: Some(a.len().min(b.len())), ..Estimate::maybe(value, metric.unit, metric.digits) };
    estimate.within(unpaired_interval(&a, &b, metric.name))
}

/// The difference of two means, as twice the mean over two strata with the second one negated.
fn unpaired_interval(a: &[f64], b: &[f64], name: &str) -> Option<Interval> {
    let negated: Vec<f64> = b.iter().map(|value| -value).collect();
    let mut stream = Stream::new(&format!("report/bootstrap/{name}"));
    let half = bootstrap(&[a, &negated], CONFIDENCE, &mut stream)?;
    Some(Interval { low: 2.0 * half.low, high: 2.0 * half.high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Episode;

    fn evaluation(speeds: &[f64], prefix: &str) -> Evaluation {
        let episode = |(index, speed): (usize, &f64)| Episode {
            stream: format!("{prefix}/{index}"),
            survived: *speed > 0.5,
            speed: *speed,
            duration: 1.0,
            ..Episode::default()
        };
        Evaluation { episodes: speeds.iter().enumerate().map(episode).collect(), ..Evaluation::default() }
    }

    fn speed(differences: &[Difference]) -> &Difference {
        differences.iter().find(|difference| difference.metric == "speed").expect("walking has a speed")
    }

    #[test]
    fn paired_episodes_cancel_what_they_share() {
        let (a, b) = (evaluation(&[1.1, 2.1, 3.1, 4.1], "1"), evaluation(&[1.0, 2.0, 3.0, 4.0], "1"));
        let paired = differences(&a, &b, "walk");
        assert!(speed(&paired).established);
        assert!((speed(&paired).difference.value.expect("four episodes") - 0.1).abs() < 1e-12);
        let other = evaluation(&[1.0, 2.0, 3.0, 4.0], "2");
        let unpaired = differences(&a, &other, "walk");
        assert!(!speed(&unpaired).established);
        assert!((speed(&unpaired).difference.value.expect("four episodes") - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_small_difference_that_is_established_does_not_read_zero() {
        let small = Estimate { value: Some(0.004), digits: 0, unit: "%".into(), ..Estimate::default() };
        let small = told_from_zero(small.within(Some(Interval { low: 0.002, high: 0.006 })));
        assert_eq!(crate::report::wording::with_interval(&small, true), "0.4 % [0.2, 0.6]");
        let plain = Estimate { value: Some(0.4), digits: 2, unit: "m".into(), ..Estimate::default() };
        assert_eq!(told_from_zero(plain.within(Some(Interval { low: 0.2, high: 0.6 }))).digits, 2);
    }

    #[test]
    fn survival_is_compared_by_an_exact_test() {
        let (a, b) = (evaluation(&[1.0; 8], "1"), evaluation(&[0.0; 8], "1"));
        let survival = &differences(&a, &b, "walk")[0];
        assert_eq!(survival.difference.value, Some(1.0));
        assert!((survival.p.expect("survival has a test") - 2.0 / 256.0).abs() < 1e-12);
        assert!(survival.established);
    }
}
