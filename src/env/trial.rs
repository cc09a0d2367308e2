//! Purpose of an environment: training, or an evaluation under its own conditions.

use std::sync::Arc;

use crate::spec::Table;

/// Purpose of an environment.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Mode {
    /// Training: everything as in the spec.
    #[default]
    Training,
    /// Evaluation of a policy: a standing start, and without the terminations that only guide training
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
    /// Deviations from the nominal physics.
    pub randomized: Randomized,
    /// Time constant of soft contacts in s; `None` is the engine's own.
    pub contact_time: Option<f64>,
}

/// Deviations of an evaluation episode's physics from the nominal ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Randomized {
    /// None.
    #[default]
    Nothing,
    /// Draws from the environment's own table.
    AsTrained,
    /// Draws from this decoded table `[randomize]`.
    By(Arc<Table>),
}
