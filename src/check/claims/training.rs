//! The samples of a training that a claim covers.

use super::ArmScope;
use crate::kinds::fine_tune;
use crate::kinds::learn::{Learner, Ppo};
use crate::spec::Section;
use crate::spec::typed::InSection;

/// The samples of a training.
pub struct Budget {
    /// After its first update.
    pub first: f64,
    /// At its end.
    pub samples: f64,
}

impl Budget {
    /// Of `learn` or `fine_tune`; `None` if the arm has none.
    pub fn of(arm: &ArmScope, stage: &str) -> Option<Self> {
        let spec = Section::new(arm.fields);
        let samples = match stage {
            Learner::SECTION => spec.at(Ppo::stop_at).unwrap_or(u64::MAX).min(spec.at(Ppo::samples)?),
            _ => spec.at(fine_tune::Ppo::samples)?,
        } as f64;
        let rollout = spec.at(Ppo::rollout)?.max(1) as f64;
        // The last update is always complete.
        Some(Self { first: rollout, samples: (samples / rollout).ceil() * rollout })
    }
}
