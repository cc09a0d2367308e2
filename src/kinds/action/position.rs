//! The action kind `position`: the policy commands joint positions of a PD servo.

use super::PhaseAction;
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the proportional gain.
    pub OwnStiffness = "the robot's own proportional gain" or Stiffness;
    /// Reference of the derivative gain.
    pub OwnDamping = "the robot's own derivative gain";
    /// Reference of actions.
    pub HalfRange = "half of the joint's range";
    /// Reference of the exploration.
    pub Exploration = "half of the joint's range" or Torque;
}

choice! {
    /// Dependence of the derivative gain on the stiffness.
    pub enum DampingRule {
        /// Proportional to the square root of the stiffness.
        Sqrt = "sqrt",
        /// Proportional to the stiffness.
        Linear = "linear",
        /// Independent of the stiffness.
        Fixed = "fixed",
    }
}

either! {
    /// The derivative gain of the servo.
    #[derive(Copy)]
    pub enum Damping {
        /// As a rule.
        Rule(DampingRule),
        /// As a share of the robot's own gain.
        Share(Ratio<OwnDamping>),
    }
}

choice! {
    /// Range of the servo's targets.
    pub enum Targets {
        /// Up to the joints' limits.
        JointLimits = "joint_limits",
        /// Beyond them, until the servo reaches its effort limit.
        EffortLimits = "effort_limits",
    }
}

choice! {
    /// Feedback of the servo.
    pub enum Feedback {
        /// The joints' true positions and velocities.
        True = "true",
        /// Its encoders.
        Measured = "measured",
    }
}

choice! {
    /// A joint-dependent reference of `scale` and `std`.
    pub enum Span {
        /// Half of the joint's range.
        JointRanges = "joint_ranges",
        /// The error at which the servo reaches its effort limit.
        EffortLimits = "effort_limits",
    }
}

either! {
    /// Size of an action of 100 %.
    #[derive(Copy)]
    pub enum SharesOf {
        /// A joint-dependent reference.
        Span(Span),
        /// An angle in rad, the same for every joint.
        Angle(Quantified<Radian>),
    }
}

kind! {
    pub struct Position in "action" = "position", needs [Joints, Torque] {
        /// Control rate: how often the policy acts. It must divide `physics.rate`.
        #[range(1.0, 1e4)]
        rate: Quantified<Hertz>,
        /// Rate of the PD servo. It must divide `physics.rate` and be a multiple of `rate`.
        #[range(1.0, 1e5)]
        servo_rate: Quantified<Hertz>,
        /// Proportional gain; the paper's K / s_p, so 12.5 % is s_p = 8.
        #[range(1e-6, 100.0)]
        stiffness: Ratio<OwnStiffness>,
        /// The derivative gain: a rule for its dependence on the stiffness, or a share of the robot's own
        /// gain. The servo's torque is delayed, so much damping makes light joints vibrate (W0512).
        #[range(0.0, 100.0)]
        #[default("\"sqrt\"")]
        damping: Damping,
        /// Command for an action of 1. It changes the scale of the policy's outputs, not the law.
        #[range(1e-6, 10.0)]
        #[default("\"100 %\"")]
        scale: Ratio<HalfRange>,
        /// Range of the targets: up to the joints' limits (default), or beyond them until the servo reaches
        /// its effort limit. A soft servo needs the latter to support the robot at all.
        targets: Option<Targets>,
        /// Reference of `scale` and `std`: half of each joint's range (default); the error at which the servo
        /// reaches the joint's effort limit, so that every joint explores with the same share of its torque
        /// at every stiffness, as under torque control; or the same angle for every joint, for example `"3.14
        /// rad"`.
        #[range(1e-3, 100.0)]
        shares_of: Option<SharesOf>,
        /// Standard deviation of the exploration noise, as the same share for every joint. A torque relative to
        /// the robot needs `shares_of = "effort_limits"`.
        #[range(1e-6, 10.0)]
        std: Ratio<Exploration>,
        /// Time between a torque command and its effect, not necessarily a whole number of physics steps.
        /// `randomize.action_delay` scales it.
        #[range(0.0, 0.1)]
        #[default("\"0 s\"")]
        delay: Quantified<Second>,
        /// Feedback of the servo: the joints' true positions and velocities (default), or its encoders:
        /// positions with the noise of `observe.joint_position`, and velocities as their difference over the
        /// last physics step, without low-pass filter. Both are shifted by `randomize.joint_offset`.
        feedback: Option<Feedback>,
        /// Whether an additional action in [0, 1] speeds up the phase, to at most twice the nominal cadence.
        #[default("true")]
        phase_modulation: bool,
        /// Effect of a phase action of 1: it doubles the increment of a control step (default), or adds the
        /// step's duration in s as a share of the cycle, as printed in the paper (2.8 times the nominal
        /// cadence for a cycle of 1.8 s).
        phase_action: Option<PhaseAction>,
        /// Whether torque that accelerates a joint fades to zero between its velocity limit and 1.25 times
        /// that limit.
        #[default("false")]
        motor_speed_limit: bool,
    }
}

impl Position {
    /// The proportional and the derivative gain, as shares of the robot's own (docs/explanation/paper.md,
    /// A20).
    pub fn gains(&self) -> (f64, f64) {
        let damping = match self.damping {
            Damping::Share(share) => share,
            Damping::Rule(DampingRule::Linear) => self.stiffness,
            Damping::Rule(DampingRule::Fixed) => 1.0,
            Damping::Rule(DampingRule::Sqrt) => self.stiffness.sqrt(),
        };
        (self.stiffness, damping)
    }

    /// Whether the servo reads its encoders rather than the true state.
    pub fn reads_encoders(&self) -> bool {
        self.feedback == Some(Feedback::Measured)
    }
}
