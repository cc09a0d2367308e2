//! Properties of tasks that reports and checks use, in addition to the tasks' keys.

/// Properties of a task.
#[derive(Clone, Copy, Debug)]
pub struct Meaning {
    /// Verb for a policy that fulfils the task: `walks`.
    pub verb: &'static str,
    /// Whether the robot travels: it has a target speed, and standing still fails the task.
    pub travels: bool,
    /// Whether its steps have flight phases.
    pub flies: bool,
    /// Whether the default pose is the reference if the task has no motion.
    pub default_pose: bool,
    /// Whether there are no ground impacts, so that the joint velocities of its reference are continuous
    /// (W0423).
    pub smooth: bool,
    /// Criteria of an evaluation in addition to survival and, if the robot travels, its speed.
    pub criteria: &'static [Criterion],
    /// The metric that a report shows first, after survival.
    pub evidence: Evidence,
}

/// A condition on the mean of a metric over the episodes.
#[derive(Clone, Copy, Debug)]
pub struct Criterion {
    /// The metric's name.
    pub metric: &'static str,
    /// The bound on the mean.
    pub bound: Bound,
    /// Its description; `{}` is the bound.
    pub text: &'static str,
    /// Whether evaluations that did not measure it are judged without it.
    pub optional: bool,
}

/// A bound on a mean.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// At least this.
    AtLeast(f64),
    /// At most this.
    AtMost(f64),
    /// At most this share of the height in m of the standing robot's base; 1 m for an unknown robot.
    AtMostOfHeight(f64),
}

/// A metric with its description.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// The description before its estimate.
    pub words: &'static str,
    /// The metric's name.
    pub metric: &'static str,
    /// A metric of the second half of the episodes, shown after it.
    pub second_half: Option<&'static str>,
}

/// Staying in place: the base may move from its start by a tenth of its height, as far as it sways above
/// fixed soles. The soles of the shipped robots reach 0.1 to 0.2 of that height forward and back.
pub const IN_PLACE: Criterion = Criterion {
    metric: "drift",
    bound: Bound::AtMostOfHeight(0.1),
    text: "stays within {} m of where it starts",
    optional: false,
};
