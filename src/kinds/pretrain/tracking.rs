//! The keys of `[pretrain]` of kind `tracking`.

use super::{Lesson, PhaseLabel};
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the labels' stiffness.
    pub OwnStiffness = "the robot's own stiffness_gain" or Stiffness;
    /// Reference of the labels' damping.
    pub OwnDamping = "the robot's own damping_gain" or Damping;
    /// Reference of the bound on the centre of pressure.
    pub Sole = "the sole's half length and half width";
}

keys! {
    /// Balance of the robot as a whole.
    pub struct Balance {
        /// Spring: acceleration of the centre of mass per position error, in g/h with h its height above the
        /// soles.
        #[range(0.0, 100.0)]
        #[default("0.5")]
        stiffness: f64,
        /// Damper: acceleration of the centre of mass per velocity error, in sqrt(g/h).
        #[range(0.0, 100.0)]
        #[default("1")]
        damping: f64,
        /// Moment that rotates the base back per tilt angle, in m g h per rad.
        #[range(0.0, 100.0)]
        #[default("0.5")]
        upright: f64,
        /// Damping of that moment divided by its stiffness.
        #[range(0.0, 10.0)]
        #[default("\"50 ms\"")]
        upright_damping: Quantified<Second>,
    }
}

kind! {
    pub struct Tracking in "pretrain" = "tracking", needs [Reference, ContactSchedule, Phase] {
        /// Stiffness of the compliant PD in the label: K/16 for walking, K/8 for running.
        #[range(0.0, 10.0)]
        #[default("\"6.25 %\"")]
        stiffness: Ratio<OwnStiffness>,
        /// Damping of the compliant PD in the label: K_d/4 for walking, K_d/sqrt(8) = 35.36 % for running.
        #[range(0.0, 10.0)]
        #[default("\"25 %\"")]
        damping: Ratio<OwnDamping>,
        /// Whether the label includes the reference motion's inertial forces: the base's vertical
        /// acceleration scales the gravity compensation, and armature times joint acceleration is added.
        /// Running needs it.
        #[default("false")]
        inertial: bool,
        /// Whether the gravity part includes the base's horizontal acceleration in the reference motion, as
        /// tilted gravity: the feet then support the swaying motion rather than the pose at rest.
        tilted_gravity: Option<bool>,
        /// Largest distance of the label's centre of pressure from the middle of a sole. Without it a foot
        /// supports any moment, as if glued to the ground, and a robot with narrow feet tips over their
        /// edges.
        #[range(0.0, 1.0)]
        pressure_within: Option<Ratio<Sole>>,
        /// Balance: feedback that returns the robot as a whole to the reference motion. Without it every
        /// joint is controlled separately.
        balance: Option<Balance>,
        /// Whether the velocity inputs are the reference velocities with the delay of the observation's
        /// low-pass filter. Matters at running cadence.
        #[default("false")]
        filter_lag: bool,
        /// Label of the phase action: masked in the loss, zero (the nominal cadence), or random from [0, 1]
        /// as printed in the paper, whose mean the actor learns.
        #[default("\"zero\"")]
        phase_label: PhaseLabel,
        ..lesson: Lesson,
    }
}
