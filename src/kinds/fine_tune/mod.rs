//! Fine-tuning: trainings that continue from the policy of `[learn]` in a changed environment. `learn/`
//! implements them.

pub mod ppo;

pub use ppo::Ppo;

use crate::spec::typed::prelude::*;

section! {
    /// Algorithm of a fine-tuning.
    pub enum FineTuning in "fine_tune", "fine-tuning" { ppo: Ppo }
}

choice! {
    /// The policies of a spec.
    pub enum Trained {
        /// The policy of `[fine_tune]`.
        FineTune = "fine_tune",
        /// The policy of `[learn]`.
        Learner = "learner",
    }
}
