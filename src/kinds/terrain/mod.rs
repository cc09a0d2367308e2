//! Terrains: the ground the robot stands on (`env/ground.rs` makes the engine's terrain of them).

pub mod box_obstacle;
pub mod flat;
pub mod height_field;
pub mod slope;

use crate::spec::Kind;

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&box_obstacle::KIND, &flat::KIND, &height_field::KIND, &slope::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
