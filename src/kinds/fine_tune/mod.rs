//! Fine-tuning: trainings that go on from the policy of `[learn]` in a changed world. What they do stands in `learn/`.

pub mod ppo;

use crate::spec::Kind;
use crate::spec::typed::prelude::*;

/// All fine-tunings, sorted by name.
pub static KINDS: &[&Kind] = &[&ppo::PPO];

/// The descriptors of all fine-tunings.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

choice! {
    /// Which of a spec's policies.
    pub enum Trained {
        /// That of `[fine_tune]`.
        FineTune = "fine_tune",
        /// That of `[learn]`.
        Learner = "learner",
    }
}
