//! What an environment is for: learning, or a trial of a policy under its own conditions.

use std::sync::Arc;

use crate::spec::Table;

/// What an environment is for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Mode {
    /// Learning: everything as the spec says.
    #[default]
    Training,
    /// Measuring a policy: a standing start, and no termination that is only a guard of training
    /// (`contact_schedule`, `joint_error`).
    Evaluation(Trial),
}

/// The conditions of an evaluation episode.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trial {
    /// Commanded speed in m/s, constant; `None` draws it as the task says.
    pub command: Option<f64>,
    /// Phase at the start.
    pub phase: f64,
    /// Standard deviation in rad of the noise on the joints of the standing start.
    pub perturbation: f64,
    /// Time limit in s; `None` is the task's.
    pub time_limit: Option<f64>,
    /// Whether encoders are noisy.
    pub noise: bool,
    /// What differs from the nominal physics.
    pub randomized: Randomized,
    /// Time constant of soft contacts in s; `None` is the engine's own.
    pub contact_time: Option<f64>,
}

/// By what the physics of an evaluation episode differ from the nominal ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Randomized {
    /// By nothing.
    #[default]
    Nothing,
    /// By draws of the environment's own table.
    AsTrained,
    /// By draws of this decoded table `[randomize]`.
    By(Arc<Table>),
}
