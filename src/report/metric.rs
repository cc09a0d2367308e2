//! The metrics of an evaluation as a report estimates them from episodes. Which there are, the registry says.

use super::estimate::Estimate;
use crate::kinds::metric::{self, MetricKind, Scale, Source};
use crate::outcome::Evaluation;
use crate::statistics::summary::mean;

/// A metric of episodes.
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
    /// The rows of the table of an evaluation, in its order.
    pub fn tabled() -> impl Iterator<Item = Self> {
        metric::KINDS.iter().copied().filter(|kind| kind.tabled).filter_map(Self::of_episodes)
    }

    /// The metric of this name.
    pub fn named(name: &str) -> Option<Self> {
        metric::find(name).and_then(Self::of_episodes)
    }

    fn of_episodes(kind: &'static MetricKind) -> Option<Self> {
        let MetricKind { label, unit, digits, source, .. } = *kind;
        let learned = matches!(source, Source::Learning(_));
        (!learned).then_some(Self { name: kind.kind.name, label, unit, digits, kind })
    }

    /// Whether it says something about a task of this kind.
    pub fn suits(&self, task: &str) -> bool {
        self.kind.tasks.is_empty() || self.kind.tasks.contains(&task)
    }

    /// Whether every episode of an evaluation has it.
    pub fn is_measured(&self, evaluation: &Evaluation) -> bool {
        self.kind.values(&evaluation.episodes).is_some()
    }

    /// Its value in every episode; none where it was not measured.
    pub fn values(&self, evaluation: &Evaluation) -> Vec<f64> {
        self.kind.values(&evaluation.episodes).unwrap_or_default()
    }

    /// Its estimate: Wilson's interval for successes, a bootstrap over episodes for means. `name` names the
    /// random stream.
    pub fn estimate(&self, evaluation: &Evaluation, name: &str) -> Estimate {
        let values = self.values(evaluation);
        if self.kind.scale == Scale::Success {
            return Estimate::share(&values.iter().map(|value| *value > 0.5).collect::<Vec<_>>());
        }
        Estimate::mean(&values, self.unit, self.digits, &format!("{name}/{}", self.name))
    }
}

/// Mean of a metric over the episodes; `None` without episodes or for an unknown name.
pub fn average(evaluation: &Evaluation, name: &str) -> Option<f64> {
    mean(&Metric::named(name)?.values(evaluation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Episode;

    fn evaluation() -> Evaluation {
        let episode =
            |survived, speed| Episode { survived, speed, duration: 8.0, steps: [10, 10], ..Episode::default() };
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
    fn a_squat_is_not_measured_by_its_speed() {
        let names: Vec<_> = Metric::tabled().filter(|metric| metric.suits("squat")).map(|metric| metric.name).collect();
        assert!(names.contains(&"survival") && names.contains(&"joint_error") && !names.contains(&"speed"));
    }
}
