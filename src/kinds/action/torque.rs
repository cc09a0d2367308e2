//! The action kind `torque`: the policy commands joint torques.

use super::PhaseAction;
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the exploration.
    pub EffortLimit = "the joint's effort limit" or Torque;
}

kind! {
    pub struct Torque in "action" = "torque", needs [Torque] {
        /// Control rate: how often the policy acts. It must divide `physics.rate`.
        #[range(1.0, 1e4)]
        rate: Quantified<Hertz>,
        /// Standard deviation of the exploration noise, as the same share for every joint.
        #[range(1e-6, 10.0)]
        std: Ratio<EffortLimit>,
        /// Time between a torque command and its effect, not necessarily a whole number of physics steps.
        /// `randomize.action_delay` scales it.
        #[range(0.0, 0.1)]
        #[default("\"0 s\"")]
        delay: Quantified<Second>,
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
