//! Metrics: the measurements of evaluations and trainings, in the order of a report's tables.
//!
//! The only list of metrics: tables, criteria and claims use it.

mod learning;
mod surviving;
mod table;

pub use table::KINDS;

use super::task::{self, Meaning};
use crate::outcome::Episode;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Signal};

/// A registry entry: descriptor, display and computation.
#[derive(Debug)]
pub struct MetricKind {
    /// Its name and documentation.
    pub kind: Kind,
    /// Its label in tables.
    pub label: &'static str,
    /// Its unit in tables; `%` for shares, whose values lie in `[0, 1]`.
    pub unit: &'static str,
    /// Its dimension; a claim's numbers must have it.
    pub dimension: Dimension,
    /// The smallest and the largest possible value of a run, in SI units; infinite if unbounded.
    pub bounds: [f64; 2],
    /// Number of decimals to print (for the unit `%`, of percents).
    pub digits: usize,
    /// The tasks that it applies to.
    pub suited: Suited,
    /// Which direction is better.
    pub better: Better,
    /// Type of its values.
    pub scale: Scale,
    /// Which rewards it sums.
    pub sums: Sums,
    /// Whether it is a speed, reward, force or torque, which is meaningless for a robot that fails its task.
    pub needs_task: bool,
    /// Whether the table of an evaluation shows it.
    pub tabled: bool,
    /// Its computation.
    pub source: Source,
}

/// Tasks that a metric applies to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suited {
    /// All.
    All,
    /// Tasks with travel.
    Travelling,
    /// Tasks in place.
    Staying,
    /// Tasks with flight phases.
    Flying,
}

impl Suited {
    fn takes(self, meaning: &Meaning) -> bool {
        match self {
            Self::All => true,
            Self::Travelling => meaning.travels,
            Self::Staying => !meaning.travels,
            Self::Flying => meaning.flies,
        }
    }
}

/// Which direction is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// More is better.
    Higher,
    /// Less is better.
    Lower,
    /// It depends on the task.
    Neither,
}

/// Type of a metric's values; a test accepts some types only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// 0 or 1 in an episode.
    Success,
    /// Any number.
    Real,
    /// A number that may lie beyond the end of the run (infinite): only ranks are meaningful.
    Censored,
}

/// Whether a metric is a sum of rewards, which only compares arms with the same rewards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sums {
    /// No rewards: it measures the robot's behaviour.
    Nothing,
    /// Rewards over control steps: the control rate must be the same, too.
    PerStep,
    /// Rewards over time.
    PerTime,
}

/// Data that a metric is computed from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// Each episode of an evaluation or a transfer.
    Episodes(fn(&Episode) -> f64),
    /// Each episode, but some may lack it: it does not apply to the ground or the robot.
    SomeEpisodes(fn(&Episode) -> Option<f64>),
    /// Each episode, given whether the policy meets the criteria of its task.
    Task,
    /// All episodes of an evaluation together; `None` if it does not apply.
    Whole(fn(&[Episode]) -> Option<f64>),
    /// The direction of failure of an evaluation's parameter sets.
    Failures(fn(&Failures) -> Option<f64>),
    /// The learning curve; `None` without learning.
    Learning(fn(&Curve) -> Option<f64>),
}

impl Source {
    /// Whether it is one number per run, without values for episodes.
    pub fn is_of_a_run(self) -> bool {
        matches!(self, Self::Whole(_) | Self::Failures(_) | Self::Learning(_))
    }
}

/// Direction of failure of an evaluation's parameter sets.
#[derive(Clone, Copy, Debug)]
pub struct Failures<'a> {
    /// The direction's entry for each parameter; a unit vector.
    pub direction: &'a [(String, f64)],
    /// The parameter of the claim.
    pub parameter: &'a str,
}

impl Failures<'_> {
    /// The absolute entry of a parameter.
    pub fn loading(&self) -> Option<f64> {
        self.direction.iter().find(|(name, _)| name == self.parameter).map(|(_, entry)| entry.abs())
    }

    /// The absolute entry of a parameter minus the largest one of the others; negative if another leads.
    fn lead(&self) -> Option<f64> {
        Some(self.loading()? - self.largest_other()?)
    }

    /// The largest absolute entry of the other parameters.
    fn largest_other(&self) -> Option<f64> {
        let others = self.direction.iter().filter(|(name, _)| name != self.parameter);
        others.map(|(_, entry)| entry.abs()).max_by(f64::total_cmp)
    }
}

/// A learning curve.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a> {
    /// Samples so far and mean return, for each update with a finished episode.
    pub points: &'a [(f64, f64)],
    /// The threshold of the claim.
    pub threshold: Option<f64>,
    /// The time between two control steps in s, if known.
    pub control_step: Option<f64>,
}

impl MetricKind {
    /// A metric that is a pure number without a better direction.
    const fn new(name: &'static str, doc: &'static str, label: &'static str, source: Source) -> Self {
        Self {
            kind: Kind { name, since: Edition::ONE, doc, params: &[], needs: &[] },
            label,
            unit: "",
            dimension: Dimension::NONE,
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
            digits: 0,
            suited: Suited::All,
            better: Better::Neither,
            scale: Scale::Real,
            sums: Sums::Nothing,
            needs_task: false,
            tabled: false,
            source,
        }
    }

    /// Sets the unit and the number of decimals.
    const fn unit(mut self, unit: &'static str, dimension: Dimension, digits: usize) -> Self {
        (self.unit, self.dimension, self.digits) = (unit, dimension, digits);
        self
    }

    /// Restricts the values to zero and above: forces, errors, counts.
    const fn not_negative(self) -> Self {
        self.between(0.0, f64::INFINITY)
    }

    /// Restricts the values to this range.
    const fn between(mut self, least: f64, most: f64) -> Self {
        self.bounds = [least, most];
        self
    }

    /// Restricts the tasks.
    const fn of(mut self, suited: Suited) -> Self {
        self.suited = suited;
        self
    }

    /// The names of its tasks; empty for all.
    pub fn tasks(&self) -> Vec<&'static str> {
        if self.suited == Suited::All {
            return Vec::new();
        }
        let suited = task::KINDS.iter().rev().filter(|task| self.suited.takes(task.meaning));
        suited.map(|task| task.kind.name).collect()
    }

    /// Whether it applies to the task with this name.
    pub fn suits(&self, task: &str) -> bool {
        self.suited == Suited::All || task::meaning(task).is_some_and(|meaning| self.suited.takes(meaning))
    }

    /// Sets the better direction.
    const fn better(mut self, better: Better) -> Self {
        self.better = better;
        self
    }

    /// Sets the type of its values.
    const fn scale(mut self, scale: Scale) -> Self {
        self.scale = scale;
        self
    }

    /// Declares it as a sum of rewards.
    const fn sums(mut self, sums: Sums) -> Self {
        self.sums = sums;
        self
    }

    /// Requires these signals in the environment.
    const fn needs(mut self, needs: &'static [Signal]) -> Self {
        self.kind.needs = needs;
        self
    }

    /// Declares it meaningless for a robot that fails its task.
    const fn of_a_task_done(mut self) -> Self {
        self.needs_task = true;
        self
    }

    /// Adds it to the table of an evaluation.
    const fn in_tables(mut self) -> Self {
        self.tabled = true;
        self
    }

    /// Its values in these episodes; `None` without episodes, or if one of them lacks it.
    pub fn values(&self, episodes: &[Episode]) -> Option<Vec<f64>> {
        let values = match self.source {
            Source::Episodes(of) => Some(episodes.iter().map(of).collect()),
            Source::SomeEpisodes(of) => episodes.iter().map(of).collect(),
            Source::Task | Source::Whole(_) | Source::Failures(_) | Source::Learning(_) => None,
        };
        values.filter(|values: &Vec<f64>| !values.is_empty())
    }
}

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|metric| &metric.kind).collect()
}

/// The metric with this name.
pub fn find(name: &str) -> Option<&'static MetricKind> {
    KINDS.iter().copied().find(|metric| metric.kind.name == name)
}

/// Additional facts for its page.
pub fn facts(kind: &Kind) -> String {
    let Some(metric) = find(kind.name) else { return String::new() };
    let stage = match metric.source {
        Source::Learning(_) => "learn",
        _ => "evaluate.NAME",
    };
    let from = match metric.source {
        Source::Learning(_) => {
            "Computed from the learning curve, with `fine_tune` in place of `learn` from that of the \
             fine-tuning"
        }
        Source::Whole(_) => "Computed from all episodes of an evaluation, and of a transfer as `deploy.NAME`",
        Source::Failures(_) => {
            "Computed from all episodes of an evaluation of the kind `parameter_sets`; the claim names the \
             `parameter`"
        }
        _ => "Measured in every episode of an evaluation, and of a transfer as `deploy.NAME`",
    };
    let unit = match metric.unit {
        "" => "a pure number".to_owned(),
        unit => format!("`{unit}`"),
    };
    let better = match metric.better {
        Better::Higher => "more is better",
        Better::Lower => "less is better",
        Better::Neither => "which direction is better depends on the task",
    };
    let tasks = match metric.tasks().as_slice() {
        [] => String::new(),
        tasks => format!(" Shown for the tasks {}.", tasks.join(", ")),
    };
    let percent = if metric.unit == "%" { 100.0 } else { 1.0 };
    let values = match metric.bounds.map(|end| percent * end) {
        [least, most] if least.is_finite() && most.is_finite() => format!(" Values: {least} to {most}."),
        [least, _] if least.is_finite() => format!(" Values: {least} or more."),
        _ => String::new(),
    };
    format!(
        "Written in a claim as `metric = \"{stage}.{}\"`. {from}. Unit: {unit}; {better}.{values}{tasks}\n",
        kind.name
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Episode;

    #[test]
    fn a_share_is_pure_and_a_page_names_the_unit() {
        for metric in KINDS {
            assert!(metric.unit != "%" || metric.dimension == Dimension::NONE, "{}", metric.kind.name);
            assert!(facts(&metric.kind).contains(metric.unit), "{}", metric.kind.name);
        }
        assert!(facts(&find("speed").expect("a metric").kind).contains("evaluate.NAME.speed"));
    }

    #[test]
    fn an_entry_of_the_direction_of_failure_counts_by_its_size() {
        let direction = [("action_delay".to_owned(), -0.8), ("leg_length".to_owned(), 0.6)];
        let of = |parameter| Failures { direction: &direction, parameter };
        assert_eq!(
            ["action_delay", "leg_length", "link_mass"].map(|name| of(name).loading()),
            [Some(0.8), Some(0.6), None]
        );
        let lead = |parameter| of(parameter).lead().expect("a lead");
        assert!((lead("action_delay") - 0.2).abs() < 1e-12 && (lead("leg_length") + 0.2).abs() < 1e-12);
        assert_eq!(of("link_mass").lead(), None);
    }

    #[test]
    fn metrics_read_their_own_field() {
        let episode = Episode {
            survived: true,
            duration: 8.0,
            steps: [10, 14],
            speed: 0.3,
            speed_error: 0.1,
            tracking_error: [0.4, 0.05],
            reward_per_second: [("a".to_owned(), 1.5), ("b".to_owned(), -0.5)].into(),
            ..Episode::default()
        };
        let values = |name: &str, episode: &Episode| {
            find(name).and_then(|metric| metric.values(std::slice::from_ref(episode)))
        };
        let value = |name: &str| values(name, &episode).unwrap_or_else(|| panic!("{name} is measured"))[0];
        let names =
            ["survival", "time_to_fall", "cadence", "speed", "speed_error", "joint_error", "height_error"];
        assert_eq!(names.map(value), [1.0, 8.0, 3.0, 0.3, 0.1, 0.4, 0.05]);
        assert_eq!((value("reward_per_s"), value("episode_reward")), (1.0, 8.0));
        assert_eq!((values("crossed", &episode), values("peak_ankle_torque", &episode)), (None, None));
        let over = Episode { crossed: Some(true), peak_ankle_torque: Some(80.0), ..Episode::default() };
        assert_eq!(
            (values("crossed", &over), values("peak_ankle_torque", &over)),
            (Some(vec![1.0]), Some(vec![80.0]))
        );
        let crossed = find("crossed").expect("a metric");
        assert_eq!(
            (crossed.values(&[over, episode]), crossed.values(&[])),
            (None, None),
            "a part is not measured"
        );
    }
}
