//! What may be written in `[pretrain]` of kind `tracking`.

use super::{EPOCHS, LEARNING_RATE, MINIBATCH, PHASE_LABELS, POSITION_NOISE, SAMPLES, TILT_NOISE, VELOCITY_NOISE};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// Keys of `balance`.
const BALANCE: &[Param] = &[
    Param::default("stiffness", Ty::Number, "0.5")
        .doc("Acceleration of the centre of mass per length that it is off, in g/h with h its height above the soles.")
        .range(0.0, 100.0),
    Param::default("damping", Ty::Number, "1")
        .doc("The same per velocity that it is off, in sqrt(g/h).")
        .range(0.0, 100.0),
    Param::default("upright", Ty::Number, "0.5")
        .doc("Moment that turns the base back per angle that it is tilted, in m g h per rad.")
        .range(0.0, 100.0),
    Param::default("upright_damping", Ty::Quantity(Dimension::TIME), "\"50 ms\"")
        .doc("Damping of that moment over its stiffness.")
        .range(0.0, 10.0),
];

/// Gravity compensation of the scheduled contacts plus a soft PD to the reference motion.
pub const TRACKING: Kind = Kind {
    name: "tracking",
    since: Edition::ONE,
    doc: include_str!("tracking.md"),
    params: &[
        SAMPLES,
        EPOCHS,
        MINIBATCH,
        LEARNING_RATE,
        POSITION_NOISE,
        VELOCITY_NOISE,
        TILT_NOISE,
        Param::default("stiffness", Ty::Ratio("the robot's own stiffness_gain"), "\"6.25 %\"")
            .doc("Stiffness of the soft PD in the label: K/16 for walking, K/8 for running.")
            .range(0.0, 10.0),
        Param::default("damping", Ty::Ratio("the robot's own damping_gain"), "\"25 %\"")
            .doc("Damping of the soft PD in the label: K_d/4 for walking, K_d/sqrt(8) = 35.36 % for running.")
            .range(0.0, 10.0),
        Param::default("inertial", Ty::Flag, "false").doc(
            "Whether the label adds what the reference motion needs beyond statics: the base's vertical acceleration scales \
             the gravity compensation and armature times joint acceleration is added. Running needs it.",
        ),
        Param::optional("tilted_gravity", Ty::Flag).doc(
            "Whether the gravity part holds the robot as it swings with the reference motion, in a gravity that the base's \
             horizontal acceleration tilts: the feet press where the swing asks for it, not where they would carry the \
             pose at rest.",
        ),
        Param::optional("pressure_within", Ty::Ratio("the sole's half length and half width"))
            .doc(
                "How far from the middle of a sole the label's centre of pressure may be. Without it a foot holds any \
                 moment, as if glued to the ground, and a robot with narrow feet rolls over their edges.",
            )
            .range(0.0, 1.0),
        Param::optional("balance", Ty::Table(BALANCE))
            .doc("What brings the robot back to the reference motion as a whole. Without it every joint is on its own."),
        Param::default("filter_lag", Ty::Flag, "false").doc(
            "Whether the velocity inputs are the reference velocities as the observation's low-pass filter delays them. \
             Matters at running cadence.",
        ),
        Param::default("phase_label", PHASE_LABELS, "\"zero\"")
            .doc("Label of the phase action: left out of the loss, zero (the nominal cadence), or drawn from [0, 1] as printed, which teaches its mean."),
    ],
    needs: &[Signal::Reference, Signal::ContactSchedule, Signal::Phase],
};
