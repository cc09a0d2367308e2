//! The learners of `[learn]`. `learn/` implements them.

pub mod ppo;

pub use ppo::Ppo;

use crate::spec::typed::prelude::*;

section! {
    /// Learning algorithm.
    pub enum Learner in "learn", "learner" { ppo: Ppo }
}
