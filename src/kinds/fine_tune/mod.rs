//! Fine-tuning: trainings that go on from the policy of `[learn]` in a changed world. What they do stands in
//! `learn/`.

pub mod ppo;

pub use ppo::Ppo;

use crate::spec::typed::prelude::*;

section! {
    /// How the policy learns on.
    pub enum FineTuning in "fine_tune", "fine-tuning" { ppo: Ppo }
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
