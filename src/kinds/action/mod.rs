//! Actions: what the policy commands and the low-level law behind it (`control/` executes it).

pub mod position;
pub mod torque;

use crate::spec::Kind;

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&position::KIND, &torque::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
