//! Tasks: what the robot is asked to do, for how long and how fast.

pub mod run;
pub mod squat;
pub mod stand;
pub mod walk;

use crate::spec::Kind;

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&run::KIND, &squat::KIND, &stand::KIND, &walk::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
