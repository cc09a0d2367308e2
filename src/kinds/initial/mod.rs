//! Initial states: where an episode starts (`env/start.rs` draws them).

pub mod default_pose;
pub mod reference;

use crate::spec::typed::prelude::*;

section! {
    /// Where episodes start.
    pub enum Initial in "initial", "initial state" { default_pose: DefaultPose, reference: OnReference }
}

impl Initial {
    /// Phases at which an episode may start standing.
    pub fn phases(&self) -> &[f64] {
        match self {
            Self::DefaultPose(pose) => &pose.phases,
            Self::OnReference(start) => &start.phases,
        }
    }
}
