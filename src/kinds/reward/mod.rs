//! Reward terms: each is a weight times a number in `[0, 1]` for one control step.

pub mod base_orientation;
pub mod contact_force;
pub mod contact_force_change;
pub mod contact_schedule;
pub mod joint_tracking;
pub mod joint_velocity;
pub mod joint_velocity_change;
pub mod mean_velocity_tracking;
pub mod torque;
pub mod torque_change;
pub mod velocity_tracking;

use super::RewardKind;
use crate::spec::Kind;
use crate::spec::typed::prelude::*;

/// Every reward kind, sorted by name.
pub static KINDS: &[&RewardKind] = &[
    &RewardKind::of::<base_orientation::BaseOrientation>(),
    &RewardKind::of::<contact_force::ContactForce>(),
    &RewardKind::of::<contact_force_change::ContactForceChange>(),
    &RewardKind::of::<contact_schedule::ContactSchedule>(),
    &RewardKind::of::<joint_tracking::JointTracking>(),
    &RewardKind::of::<joint_velocity::JointVelocity>(),
    &RewardKind::of::<joint_velocity_change::JointVelocityChange>(),
    &RewardKind::of::<mean_velocity_tracking::MeanVelocityTracking>(),
    &RewardKind::of::<torque::Torque>(),
    &RewardKind::of::<torque_change::TorqueChange>(),
    &RewardKind::of::<velocity_tracking::VelocityTracking>(),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

terms! {
    /// Reward terms.
    pub struct Rewards in "reward", "reward term";
}

/// The paper's kernel exp(-k x).
fn kernel(k: f64, x: f64) -> f64 {
    libm::exp(-k * x)
}

/// Squared difference in (m/s)^2 between a horizontal velocity and the commanded one, whose lateral part is
/// zero.
fn squared_error(velocity: &[f64; 3], command_speed: f64) -> f64 {
    let forward = velocity[0] - command_speed;
    forward * forward + velocity[1] * velocity[1]
}

/// Euclidean norm of a vector.
fn norm(vector: &[f64; 3]) -> f64 {
    (vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;
    use crate::spec::{Quantity, Section, Table, Value};

    #[test]
    fn the_paper_table_pays_at_most_1_70() {
        // In the order of the registry; the mean velocity is not in the paper.
        let weights = [0.3, 0.1, 0.1, 0.2, 0.35, 0.05, 0.05, 0.0, 0.05, 0.2, 0.3];
        let table = Table::from([("k".into(), Value::Quantity(Quantity { si: 1.0, text: "1".into() }))]);
        let world = Sample::new(12);
        let total: f64 = KINDS
            .iter()
            .zip(weights)
            .map(|(entry, weight)| weight * (entry.build)(Section::new(&table)).value(&world.signals()))
            .sum();
        assert!((total - 1.70).abs() < 1e-12);
    }

    #[test]
    fn the_registry_is_sorted_and_every_page_has_a_summary() {
        assert!(KINDS.windows(2).all(|pair| pair[0].kind.name < pair[1].kind.name));
        assert!(
            KINDS.iter().all(|entry| entry.kind.doc.lines().next().is_some_and(|line| line.ends_with('.')))
        );
    }
}
