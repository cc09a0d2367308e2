//! The metrics of an evaluation, estimated from its episodes. The registry defines them.

use super::estimate::Estimate;
use crate::kinds::metric::{self, MetricKind, Scale, Source};
use crate::outcome::{Episode, Evaluation};
use crate::statistics::summary::mean;

/// The metrics of the second half of the time limit; they are 0 in an episode that ended before it.
const SECOND_HALF: [&str; 2] = ["steady_speed", "steady_flight_per_step"];

/// A metric measured per episode.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Its name in templates, claims and `specforge trace`.
    pub name: &'static str,
    /// Its name in tables.
    pub label: &'static str,
    /// Its unit; `%` for shares.
    pub unit: &'static str,
    /// Decimals worth printing.
    pub digits: usize,
    /// The registry's entry.
    kind: &'static MetricKind,
}

impl Metric {
    /// The metrics in the table of an evaluation, in its order.
    pub fn tabled() -> impl Iterator<Item = Self> {
        metric::KINDS.iter().copied().filter(|kind| kind.tabled).filter_map(Self::of_episodes)
    }

    /// The metric of this name.
    pub fn named(name: &str) -> Option<Self> {
        metric::find(name).and_then(Self::of_episodes)
    }

    fn of_episodes(kind: &'static MetricKind) -> Option<Self> {
        let MetricKind { label, unit, digits, source, .. } = *kind;
        let is_of_episodes = matches!(source, Source::Episodes(_) | Source::SomeEpisodes(_));
        is_of_episodes.then_some(Self { name: kind.kind.name, label, unit, digits, kind })
    }

    /// Whether it is meaningful for a task of this kind.
    pub fn suits(&self, task: &str) -> bool {
        self.kind.suits(task)
    }

    /// Whether every episode of an evaluation has it. For the second half, whether any episode reached it.
    pub fn is_measured(&self, evaluation: &Evaluation) -> bool {
        self.kind.values(&evaluation.episodes).is_some()
            && self.without(evaluation) < evaluation.episodes.len()
    }

    /// Number of episodes that ended before the measured part, and count as 0.
    pub fn without(&self, evaluation: &Evaluation) -> usize {
        let ended = |episode: &&Episode| episode.duration < 0.5 * evaluation.time_limit;
        if SECOND_HALF.contains(&self.name) { evaluation.episodes.iter().filter(ended).count() } else { 0 }
    }

    /// Its value in every episode; empty if not measured.
    pub fn values(&self, evaluation: &Evaluation) -> Vec<f64> {
        self.kind.values(&evaluation.episodes).unwrap_or_default()
    }

    /// Its estimate: Wilson's interval for success rates, a bootstrap over episodes for means.
    pub fn estimate(&self, evaluation: &Evaluation) -> Estimate {
        let values = self.values(evaluation);
        if self.kind.scale == Scale::Success {
            return Estimate::share(&values.iter().map(|value| *value > 0.5).collect::<Vec<_>>());
        }
        Estimate::mean(&values, self.unit, self.digits, self.name)
    }
}

/// Mean of a metric over the episodes; `None` without episodes or for an unknown name.
pub fn average(evaluation: &Evaluation, name: &str) -> Option<f64> {
    mean(&Metric::named(name)?.values(evaluation))
}

#[cfg(test)]
mod tests {
    use super::*;
    fn evaluation() -> Evaluation {
        let episode = |survived, speed| Episode {
            survived,
            speed,
            duration: 8.0,
            steps: [10, 10],
            ..Episode::default()
        };
        Evaluation { episodes: vec![episode(true, 1.0), episode(false, 0.5)], ..Evaluation::default() }
    }

    #[test]
    fn metrics_read_the_episodes() {
        assert_eq!(average(&evaluation(), "survival"), Some(0.5));
        assert_eq!(average(&evaluation(), "speed"), Some(0.75));
        assert_eq!(average(&evaluation(), "cadence"), Some(2.5));
        assert_eq!(average(&evaluation(), "no_such_metric"), None);
    }

    #[test]
    fn a_second_half_that_no_episode_reached_was_not_measured() {
        let lasting = |durations: &[f64]| {
            let episode = |duration: &f64| Episode { duration: *duration, ..Episode::default() };
            let episodes = durations.iter().map(episode).collect();
            Evaluation { time_limit: 16.0, episodes, ..Evaluation::default() }
        };
        let metric = |name| Metric::named(name).expect("a metric");
        let steady = metric("steady_speed");
        assert!(!steady.is_measured(&lasting(&[2.0, 7.9])) && metric("speed").is_measured(&lasting(&[2.0])));
        let some = lasting(&[2.0, 16.0]);
        assert_eq!((steady.is_measured(&some), steady.without(&some)), (true, 1));
    }

    #[test]
    fn a_squat_is_not_measured_by_its_speed() {
        let names: Vec<_> =
            Metric::tabled().filter(|metric| metric.suits("squat")).map(|metric| metric.name).collect();
        assert!(names.contains(&"survival") && names.contains(&"joint_error") && !names.contains(&"speed"));
    }
}
