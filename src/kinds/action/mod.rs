//! Actions: the policy's commands and the low-level law that executes them (`control/`).

pub mod position;
pub mod torque;

pub use position::Position;
pub use torque::Torque;

use crate::spec::typed::prelude::*;

choice! {
    /// Effect of a phase action of 1 in a control step.
    pub enum PhaseAction {
        /// Adds the step's duration in s as a share of the cycle.
        Share = "share",
        /// Adds the step's duration once more.
        Time = "time",
    }
}

section! {
    /// What the policy commands.
    pub enum Action in "action", "action" { position: Position, torque: Torque }
}

impl Action {
    /// Control rate in Hz.
    pub fn rate(&self) -> f64 {
        match self {
            Self::Position(action) => action.rate,
            Self::Torque(action) => action.rate,
        }
    }

    /// Delay of the torque in s.
    pub fn delay(&self) -> f64 {
        match self {
            Self::Position(action) => action.delay,
            Self::Torque(action) => action.delay,
        }
    }

    /// Standard deviation of the exploration, relative to the kind's reference.
    pub fn std(&self) -> f64 {
        match self {
            Self::Position(action) => action.std,
            Self::Torque(action) => action.std,
        }
    }

    /// Whether the last action advances the phase.
    pub fn phase_modulation(&self) -> bool {
        match self {
            Self::Position(action) => action.phase_modulation,
            Self::Torque(action) => action.phase_modulation,
        }
    }

    /// Effect of a phase action of 1 in a control step.
    pub fn phase_action(&self) -> PhaseAction {
        let written = match self {
            Self::Position(action) => action.phase_action,
            Self::Torque(action) => action.phase_action,
        };
        written.unwrap_or(PhaseAction::Time)
    }

    /// Whether torque that drives a joint beyond its velocity limit fades out.
    pub fn motor_speed_limit(&self) -> bool {
        match self {
            Self::Position(action) => action.motor_speed_limit,
            Self::Torque(action) => action.motor_speed_limit,
        }
    }

    /// The servo under position control.
    pub fn servo(&self) -> Option<&Position> {
        match self {
            Self::Position(servo) => Some(servo),
            Self::Torque(_) => None,
        }
    }
}
