//! The learners that `[learn]` may name. What they do stands in `learn/`.

pub mod ppo;

use crate::spec::Kind;

/// All learners, sorted by name.
pub static KINDS: &[&Kind] = &[&ppo::PPO];

/// The descriptors of all learners.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
