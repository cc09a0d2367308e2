//! Pre-training: fitting the actor to labels before any simulation. `learn/pretrain/` implements it.

pub mod gravity_compensation;
pub mod tracking;

pub use gravity_compensation::GravityCompensation;
pub use tracking::Tracking;

use crate::spec::typed::prelude::*;

section! {
    /// Labels of the actor.
    pub enum Pretraining in "pretrain",
    "pre-training" { gravity_compensation: GravityCompensation, tracking: Tracking }
}

reference! {
    /// Reference of the velocity noise.
    pub VelocityScale = "the observation's joint velocity scale";
}

choice! {
    /// Label of the phase action.
    pub enum PhaseLabel {
        /// None: it is masked in the loss.
        Masked = "masked",
        /// Random from [0, 1]; the actor learns the mean.
        Random = "random",
        /// The nominal cadence.
        Zero = "zero",
    }
}

keys! {
    /// Common keys of all pre-trainings.
    pub struct Lesson in "pretrain" {
        /// Number of labelled states; 5 % more are drawn and held out. The paper: 200 k.
        #[range(1.0, 1e9)]
        #[default("\"200 k\"")]
        samples: u64,
        /// Passes over the samples.
        #[range(1.0, 1000.0)]
        #[default("10")]
        epochs: u64,
        /// Samples per gradient step.
        #[range(1.0, 1e8)]
        #[default("512")]
        minibatch: usize,
        /// Adam's step size at the first and at the last step, linear in between.
        #[range(0.0, 1.0)]
        #[length(Length::Each(&["first", "last"]))]
        #[default("[1e-3, 1e-5]")]
        learning_rate: Vec<f64>,
        /// Standard deviation of the joint positions around the pose, drawn once per sample.
        #[range(-3.2, 3.2)]
        #[default("{ uniform = [\"0.05 rad\", \"0.15 rad\"] }")]
        position_noise: Sampled<Radian>,
        /// Standard deviation of the joint velocities.
        #[range(0.0, 100.0)]
        #[default("\"100 %\"")]
        velocity_noise: Ratio<VelocityScale>,
        /// Standard deviations of the base's roll, pitch and yaw.
        #[range(0.0, 3.2)]
        #[length(Length::Each(&["roll", "pitch", "yaw"]))]
        #[default("[\"0.06 rad\", \"0.06 rad\", \"0.15 rad\"]")]
        tilt_noise: Vec<Quantified<Radian>>,
    }
}

impl Pretraining {
    /// Common keys of all pre-trainings.
    pub fn lesson(&self) -> &Lesson {
        match self {
            Self::GravityCompensation(kind) => &kind.lesson,
            Self::Tracking(kind) => &kind.lesson,
        }
    }

    /// Label of the phase action.
    pub fn phase_label(&self) -> PhaseLabel {
        match self {
            Self::GravityCompensation(kind) => kind.phase_label,
            Self::Tracking(kind) => kind.phase_label,
        }
    }
}
