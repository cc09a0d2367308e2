//! Initial states of episodes (drawn by `env/start.rs`).

pub mod default_pose;
pub mod reference;

use crate::spec::typed::prelude::*;

section! {
    /// Distribution of initial states.
    pub enum Initial in "initial", "initial state" { default_pose: DefaultPose, reference: OnReference }
}

impl Initial {
    /// Phases of standing starts.
    pub fn phases(&self) -> &[f64] {
        match self {
            Self::DefaultPose(pose) => &pose.phases,
            Self::OnReference(start) => &start.phases,
        }
    }
}
