//! What may be written in `[pretrain]` of kind `tracking`.

use super::{Lesson, PhaseLabel};
use crate::spec::typed::prelude::*;

reference! {
    /// What the stiffness of the labels is a share of.
    pub OwnStiffness = "the robot's own stiffness_gain";
    /// What their damping is a share of.
    pub OwnDamping = "the robot's own damping_gain";
    /// What the centre of pressure keeps within a share of.
    pub Sole = "the sole's half length and half width";
}

keys! {
    /// What brings a robot back to its reference motion as a whole.
    pub struct Balance {
        /// Acceleration of the centre of mass per length that it is off, in g/h with h its height above the
        /// soles.
        #[range(0.0, 100.0)]
        #[default("0.5")]
        stiffness: f64,
        /// The same per velocity that it is off, in sqrt(g/h).
        #[range(0.0, 100.0)]
        #[default("1")]
        damping: f64,
        /// Moment that turns the base back per angle that it is tilted, in m g h per rad.
        #[range(0.0, 100.0)]
        #[default("0.5")]
        upright: f64,
        /// Damping of that moment over its stiffness.
        #[range(0.0, 10.0)]
        #[default("\"50 ms\"")]
        upright_damping: Quantified<Second>,
    }
}

kind! {
    pub struct Tracking in "pretrain" = "tracking", needs [Reference, ContactSchedule, Phase] {
        /// Stiffness of the soft PD in the label: K/16 for walking, K/8 for running.
        #[range(0.0, 10.0)]
        #[default("\"6.25 %\"")]
        stiffness: Ratio<OwnStiffness>,
        /// Damping of the soft PD in the label: K_d/4 for walking, K_d/sqrt(8) = 35.36 % for running.
        #[range(0.0, 10.0)]
        #[default("\"25 %\"")]
        damping: Ratio<OwnDamping>,
        /// Whether the label adds what the reference motion needs beyond statics: the base's vertical
        /// acceleration scales the gravity compensation and armature times joint acceleration is added.
        /// Running needs it.
        #[default("false")]
        inertial: bool,
        /// Whether the gravity part holds the robot as it swings with the reference motion, in a gravity that
        /// the base's horizontal acceleration tilts: the feet press where the swing asks for it, not where
        /// they would carry the pose at rest.
        tilted_gravity: Option<bool>,
        /// How far from the middle of a sole the label's centre of pressure may be. Without it a foot holds
        /// any moment, as if glued to the ground, and a robot with narrow feet rolls over their edges.
        #[range(0.0, 1.0)]
        pressure_within: Option<Ratio<Sole>>,
        /// What brings the robot back to the reference motion as a whole. Without it every joint is on its
        /// own.
        balance: Option<Balance>,
        /// Whether the velocity inputs are the reference velocities as the observation's low-pass filter
        /// delays them. Matters at running cadence.
        #[default("false")]
        filter_lag: bool,
        /// Label of the phase action: left out of the loss, zero (the nominal cadence), or drawn from [0, 1]
        /// as printed, which teaches its mean.
        #[default("\"zero\"")]
        phase_label: PhaseLabel,
        ..lesson: Lesson,
    }
}
