//! What may be written in `[pretrain]` of kind `gravity_compensation`.

use super::{EPOCHS, LEARNING_RATE, MINIBATCH, PHASE_LABELS, POSITION_NOISE, SAMPLES, TILT_NOISE, VELOCITY_NOISE};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The paper's pre-training: torques that hold the robot against gravity.
pub const GRAVITY_COMPENSATION: Kind = Kind {
    name: "gravity_compensation",
    since: Edition::ONE,
    doc: include_str!("gravity_compensation.md"),
    params: &[
        SAMPLES,
        EPOCHS,
        MINIBATCH,
        LEARNING_RATE,
        POSITION_NOISE,
        VELOCITY_NOISE,
        TILT_NOISE,
        Param::default("standing_share", Ty::Ratio("all samples"), "\"50 %\"")
            .doc("Share of the samples about the default pose; the others are about the reference motion.")
            .range(0.0, 1.0),
        Param::default("contact_height", Ty::Quantity(Dimension::LENGTH), "\"0.02 m\"")
            .doc("A foot counts as standing when its sole is at most this far above the lower sole.")
            .range(0.0, 1.0),
        Param::default("phase_label", PHASE_LABELS, "\"masked\"")
            .doc("Label of the phase action: left out of the loss, zero (the nominal cadence), or drawn from [0, 1] as printed, which teaches its mean."),
    ],
    needs: &[],
};
