//! Initial states: where an episode starts (`env/start.rs` draws them).

pub mod default_pose;
pub mod reference;

use crate::quantity::Dimension;
use crate::spec::{Kind, Param, Ty};

/// Noise of the standing starts.
pub const STANDING_NOISE: Param = Param::optional("standing_noise", Ty::Sampler(Dimension::ANGLE)).range(-3.2, 3.2).doc(
    "Added to each joint position of the standing starts, as evaluations do by their `perturbation`; without it they \
     are all alike.",
);

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&default_pose::KIND, &reference::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}
