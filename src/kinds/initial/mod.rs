//! Initial states: where an episode starts (`env/start.rs` draws them).

pub mod default_pose;
pub mod reference;

use crate::spec::Kind;

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&default_pose::KIND, &reference::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
