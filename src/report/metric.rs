//! The metrics of an evaluation: what the table's rows are and how they are estimated from episodes.

use super::estimate::Estimate;
use crate::evaluate::outcome::{Episode, Evaluation};

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
    /// Tasks it is meant for; empty for all.
    pub tasks: &'static [&'static str],
    /// Its value in an episode.
    pub of: fn(&Episode) -> f64,
}

const MOVING: &[&str] = &["walk", "run"];

/// All metrics, in the order of the table.
pub static METRICS: &[Metric] = &[
    metric("survival", "survival", ("%", 0), &[], |e| f64::from(u8::from(e.survived))),
    metric("time_to_fall", "time until the fall or the limit", ("s", 2), &[], |e| e.duration),
    metric("single_support", "single support", ("%", 0), &[], |e| e.single_support),
    metric("left_support", "on the left foot alone", ("%", 0), MOVING, |e| e.left_support),
    metric("right_support", "on the right foot alone", ("%", 0), MOVING, |e| e.right_support),
    metric("flight", "no foot on the ground", ("%", 0), MOVING, |e| e.flight),
    metric("flight_per_step", "steps with a flight phase", ("%", 1), &["run"], |e| e.flight_per_step),
    metric("steady_flight_per_step", "steps with a flight phase, second half", ("%", 1), &["run"], |e| {
        e.steady_flight_per_step
    }),
    metric("starting_steps", "steps until every step has a flight phase", ("", 1), &["run"], |e| {
        f64::from(e.starting_steps)
    }),
    metric("left_steps", "steps of the left foot", ("", 1), MOVING, |e| f64::from(e.steps[0])),
    metric("right_steps", "steps of the right foot", ("", 1), MOVING, |e| f64::from(e.steps[1])),
    metric("cadence", "touch-downs per second", ("/s", 2), MOVING, cadence),
    metric("speed", "mean forward speed", ("m/s", 3), MOVING, |e| e.speed),
    metric("steady_speed", "speed in the second half", ("m/s", 3), MOVING, |e| e.steady_speed),
    metric("speed_error", "speed error", ("m/s", 3), MOVING, |e| e.speed_error),
    metric("distance", "distance", ("m", 2), MOVING, |e| e.distance),
    metric("joint_error", "largest joint distance from the reference", ("rad", 2), &[], |e| e.tracking_error[0]),
    metric("height_error", "largest base-height distance from the reference", ("m", 3), &[], |e| e.tracking_error[1]),
    metric("peak_foot_force", "peak vertical foot force", ("N", 0), &[], |e| e.peak_foot_force),
    metric("torque_rms", "torque rms", ("N m", 1), &[], |e| e.torque_rms),
];

const fn metric(
    name: &'static str,
    label: &'static str,
    (unit, digits): (&'static str, usize),
    tasks: &'static [&'static str],
    of: fn(&Episode) -> f64,
) -> Metric {
    Metric { name, label, unit, digits, tasks, of }
}

fn cadence(episode: &Episode) -> f64 {
    if episode.duration > 0.0 { f64::from(episode.steps[0] + episode.steps[1]) / episode.duration } else { 0.0 }
}

impl Metric {
    /// The metric of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        METRICS.iter().find(|metric| metric.name == name)
    }

    /// Whether it says something about a task of this kind.
    pub fn suits(&self, task: &str) -> bool {
        self.tasks.is_empty() || self.tasks.contains(&task)
    }

    /// Its value in every episode.
    pub fn values(&self, evaluation: &Evaluation) -> Vec<f64> {
        evaluation.episodes.iter().map(self.of).collect()
    }

    /// Its estimate: Wilson's interval for survival, a bootstrap over episodes for means. `name` names the
    /// random stream.
    pub fn estimate(&self, evaluation: &Evaluation, name: &str) -> Estimate {
        if self.name == "survival" {
            let outcomes: Vec<bool> = evaluation.episodes.iter().map(|episode| episode.survived).collect();
            return Estimate::share(&outcomes);
        }
        Estimate::mean(&self.values(evaluation), self.unit, self.digits, &format!("{name}/{}", self.name))
    }
}

/// Mean of a metric over the episodes; `None` without episodes or for an unknown name.
pub fn average(evaluation: &Evaluation, name: &str) -> Option<f64> {
    super::statistics::summary::mean(&Metric::named(name)?.values(evaluation))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let names: Vec<_> = METRICS.iter().filter(|metric| metric.suits("squat")).map(|metric| metric.name).collect();
        assert!(names.contains(&"survival") && names.contains(&"joint_error") && !names.contains(&"speed"));
    }
}
