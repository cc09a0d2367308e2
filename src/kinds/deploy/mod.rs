//! Deployments of a trained policy. What they do stands in `deploy/`.

pub mod export;
pub mod transfer;

use crate::spec::Kind;

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&export::KIND, &transfer::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
