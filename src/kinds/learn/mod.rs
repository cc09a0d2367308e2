//! The learners that `[learn]` may name. What they do stands in `learn/`.

pub mod ppo;

pub use ppo::Ppo;

use crate::spec::typed::prelude::*;

section! {
    /// How the policy learns.
    pub enum Learner in "learn", "learner" { ppo: Ppo }
}
