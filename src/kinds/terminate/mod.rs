//! Terminations: conditions that end an episode early. The reward of the last step is then zero.

pub mod base_height;
pub mod base_tilt;
pub mod contact_schedule;
pub mod ground_contact;
pub mod joint_error;
pub mod self_collision;

use super::TerminationKind;
use crate::spec::Kind;
use crate::spec::typed::prelude::*;

/// Every termination kind, sorted by name.
pub static KINDS: &[&TerminationKind] = &[
    &TerminationKind::of::<base_height::BaseHeight>(),
    &TerminationKind::of::<base_tilt::BaseTilt>(),
    &TerminationKind::of::<contact_schedule::ContactSchedule>(),
    &TerminationKind::of::<ground_contact::GroundContact>(),
    &TerminationKind::of::<joint_error::JointError>(),
    &TerminationKind::of::<self_collision::SelfCollision>(),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

terms! {
    /// Terminations.
    pub struct Terminations in "terminate", "termination";
}
