//! The ways to fit the actor to labels before any simulation. What they do stands in `learn/pretrain/`.

pub mod gravity_compensation;
pub mod tracking;

use crate::quantity::Dimension;
use crate::spec::{Kind, Length, Param, Ty};

/// All pre-trainings, sorted by name.
pub static KINDS: &[&Kind] = &[&gravity_compensation::GRAVITY_COMPENSATION, &tracking::TRACKING];

/// The descriptors of all pre-trainings.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

const SAMPLES: Param = Param::default("samples", Ty::Count, "\"200 k\"")
    .doc("Labelled states; a twentieth more is drawn and held out. The paper: 200 k.")
    .range(1.0, 1e9);

const EPOCHS: Param = Param::default("epochs", Ty::Count, "10").doc("Passes over the samples.").range(1.0, 1000.0);

const MINIBATCH: Param =
    Param::default("minibatch", Ty::Count, "512").doc("Samples per gradient step.").range(1.0, 1e8);

const LEARNING_RATE: Param = Param::default("learning_rate", Ty::List(&Ty::Number), "[1e-3, 1e-5]")
    .doc("Adam's step size at the first and at the last step, linear between.")
    .range(0.0, 1.0)
    .length(Length::Each(&["first", "last"]));

const POSITION_NOISE: Param =
    Param::default("position_noise", Ty::Sampler(Dimension::ANGLE), "{ uniform = [\"0.05 rad\", \"0.15 rad\"] }")
        .range(-3.2, 3.2)
        .doc("Standard deviation of the joint positions about the pose, drawn once per sample.");

const VELOCITY_NOISE: Param =
    Param::default("velocity_noise", Ty::Ratio("the observation's joint velocity scale"), "\"100 %\"")
        .doc("Standard deviation of the joint velocities.")
        .range(0.0, 100.0);

const TILT_NOISE: Param = Param::default(
    "tilt_noise",
    Ty::List(&Ty::Quantity(Dimension::ANGLE)),
    "[\"0.06 rad\", \"0.06 rad\", \"0.15 rad\"]",
)
.doc("Standard deviations of the base's roll, pitch and yaw.")
.range(0.0, 3.2)
.length(Length::Each(&["roll", "pitch", "yaw"]));

const PHASE_LABELS: Ty = Ty::Choice(&["masked", "random", "zero"]);
