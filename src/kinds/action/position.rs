//! The action kind `position`: the policy commands joint positions of a PD servo.

use super::PhaseAction;
use crate::spec::typed::prelude::*;

reference! {
    /// What the proportional gain is a share of.
    pub OwnStiffness = "the robot's own proportional gain";
    /// What the derivative gain is a share of.
    pub OwnDamping = "the robot's own derivative gain";
    /// What actions and the exploration are shares of.
    pub HalfRange = "half of the joint's range";
}

choice! {
    /// How the derivative gain follows the stiffness.
    pub enum DampingRule {
        /// As its root.
        Sqrt = "sqrt",
        /// In proportion.
        Linear = "linear",
        /// Not at all.
        Fixed = "fixed",
    }
}

either! {
    /// The derivative gain of the servo.
    #[derive(Copy)]
    pub enum Damping {
        /// As a rule.
        Rule(DampingRule),
        /// As a share of the robot's own.
        Share(Ratio<OwnDamping>),
    }
}

choice! {
    /// How far the targets of the servo go.
    pub enum Targets {
        /// To the joints' limits.
        JointLimits = "joint_limits",
        /// Beyond them, until the effort limit is all that the servo gives.
        EffortLimits = "effort_limits",
    }
}

choice! {
    /// What the servo reads.
    pub enum Feedback {
        /// The joints' true positions and velocities.
        True = "true",
        /// Its encoders.
        Measured = "measured",
    }
}

choice! {
    /// A quantity of each joint that `scale` and `std` are shares of.
    pub enum Span {
        /// Half of its range.
        JointRanges = "joint_ranges",
        /// The error at which the servo gives its effort limit.
        EffortLimits = "effort_limits",
    }
}

either! {
    /// What an action of 100 % is.
    #[derive(Copy)]
    pub enum SharesOf {
        /// A quantity of each joint.
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
        /// The derivative gain: how it follows the stiffness, or a share of the robot's own. The delay
        /// holds the servo's torque back, so much damping of light joints makes them shake (W0512).
        #[range(0.0, 100.0)]
        #[default("\"sqrt\"")]
        damping: Damping,
        /// What an action of 1 commands; it changes the numbers inside the policy, not the law.
        #[range(1e-6, 10.0)]
        #[default("\"100 %\"")]
        scale: Ratio<HalfRange>,
        /// How far the targets go: to the joints' limits, which is also what is meant without this key,
        /// or beyond them until the effort limit is all that the servo gives. A soft servo needs the
        /// latter to hold the robot at all.
        targets: Option<Targets>,
        /// What `scale` and `std` are shares of: half of each joint's range (the default); the error at
        /// which the servo gives the joint's effort limit, with which every joint explores with the
        /// same share of its torque at every stiffness, as under torque control; or an angle, the same
        /// for every joint, as `"3.14 rad"`.
        #[range(1e-3, 100.0)]
        shares_of: Option<SharesOf>,
        /// Standard deviation of the exploration noise, the same share for every joint.
        #[range(1e-6, 10.0)]
        std: Ratio<HalfRange>,
        /// Time between a torque command and its effect; it need not be a whole number of physics
        /// steps. `randomize.action_delay` scales it.
        #[range(0.0, 0.1)]
        #[default("\"0 s\"")]
        delay: Quantified<Second>,
        /// What the servo reads: the joints' true positions and velocities (the default), or its
        /// encoders: positions with the noise of `observe.joint_position`, and as the velocity their
        /// difference over the last physics step, not low-passed. Both are shifted by
        /// `randomize.joint_offset`.
        feedback: Option<Feedback>,
        /// Whether one more action in [0, 1] speeds the phase up, to at most twice the nominal cadence.
        #[default("true")]
        phase_modulation: bool,
        /// What a phase action of 1 adds to a control step: as much time again, which is also what is
        /// meant without this key, or the step's seconds read as a share of the cycle, as printed (2.8
        /// times the nominal cadence for a cycle of 1.8 s).
        phase_action: Option<PhaseAction>,
        /// Whether torque that drives a joint faster fades to zero between its velocity limit and 1.25
        /// times that.
        #[default("false")]
        motor_speed_limit: bool,
    }
}

impl Position {
    /// The proportional and the derivative gain, in shares of the robot's own (docs/explanation/paper.md,
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

    /// Whether the servo reads its encoders, not the true state.
    pub fn reads_encoders(&self) -> bool {
        self.feedback == Some(Feedback::Measured)
    }
}
