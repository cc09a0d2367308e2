//! What a task asks of a policy: what reports and checks know of it beside its keys.

/// What a task asks of a policy.
#[derive(Clone, Copy, Debug)]
pub struct Meaning {
    /// What a policy does that does the task: `walks`.
    pub verb: &'static str,
    /// Whether the robot goes somewhere: it has a speed to reach, and standing still is not the task.
    pub travels: bool,
    /// Whether its steps have flight phases.
    pub flies: bool,
    /// Whether the robot's default pose is the reference where the task names no motion.
    pub default_pose: bool,
    /// Whether nothing strikes the ground, so that the joint velocities of its reference do not jump (W0423).
    pub smooth: bool,
    /// What an evaluation must show beside survival and, where the robot travels, its speed.
    pub criteria: &'static [Criterion],
    /// What a report tells first of an evaluation after its survival.
    pub evidence: Evidence,
}

/// One condition on the mean of a metric over the episodes.
#[derive(Clone, Copy, Debug)]
pub struct Criterion {
    /// The metric's name.
    pub metric: &'static str,
    /// The mean's bound.
    pub bound: Bound,
    /// What is asked; `{}` is the bound.
    pub text: &'static str,
    /// Whether evaluations in which it was not measured are judged without it.
    pub optional: bool,
}

/// A bound of a mean.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// It is at least this.
    AtLeast(f64),
    /// It is at most this.
    AtMost(f64),
    /// It is at most this share of the height in m at which the base stands; of a robot that is not known 1
    /// m.
    AtMostOfHeight(f64),
}

/// A metric in words.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// The words before its estimate.
    pub words: &'static str,
    /// The metric's name.
    pub metric: &'static str,
    /// A metric of the second half of the episodes, told behind it.
    pub second_half: Option<&'static str>,
}

/// Staying in place: the base may be off its start by a tenth of its height, as far as it sways above soles
/// that stay. The soles of the shipped robots reach 0.1 to 0.2 of that height forward and back.
pub const IN_PLACE: Criterion = Criterion {
    metric: "drift",
    bound: Bound::AtMostOfHeight(0.1),
    text: "stays within {} m of where it starts",
    optional: false,
};
