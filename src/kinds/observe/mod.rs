//! Observations: the policy's inputs, in this canonical order whatever the order in the spec.

pub mod base_orientation;
pub mod command;
pub mod joint_position;
pub mod joint_velocity;
pub mod phase;

use serde::{Deserialize, Serialize};

use crate::robot::{Leg, Robot};
use crate::spec::typed::prelude::*;
use crate::spec::{Kind, Section};

/// An observation: its inputs and how they are measured.
pub trait Observed {
    /// Its inputs, in order.
    fn inputs(&self, subject: &Subject) -> Vec<Input>;
    /// The raw value (SI units) of one of them.
    fn read(readings: &Readings, index: usize) -> f64;
}

/// A registry entry.
pub struct ObserveKind {
    /// Its descriptor.
    pub kind: &'static Kind,
    /// Its inputs, in order.
    pub inputs: fn(Section, &Subject) -> Vec<Input>,
    /// The raw value (SI units) of one of them.
    pub read: fn(&Readings, usize) -> f64,
}

impl ObserveKind {
    const fn of<Term: Declared + Observed>() -> Self {
        Self {
            kind: Term::KIND,
            inputs: |section, subject| section.read::<Term>().inputs(subject),
            read: Term::read,
        }
    }
}

/// The context of an observation.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Range of the commanded speed in m/s; `[0, 0]` without a command.
    pub command: [f64; 2],
}

/// Measurements, in SI units. Joint vectors are in joint order.
///
/// With `mirror` the joint vectors are those of the mirrored robot: [`Readings::joint_position`] and
/// [`Readings::joint_velocity`] apply the mirror, the slices themselves are as measured.
#[derive(Clone, Copy, Debug)]
pub struct Readings<'a> {
    /// Fixed-XYZ angles of the base (roll, pitch, yaw) in rad.
    pub attitude: [f64; 3],
    /// Measured joint positions in rad.
    pub position: &'a [f64],
    /// Measured (filtered) joint velocities in rad/s.
    pub velocity: &'a [f64],
    /// Phase in `[0, 1)`.
    pub phase: f64,
    /// Commanded forward speed in m/s.
    pub command_speed: f64,
    /// The robot's mirror map, for a mirrored observation.
    pub mirror: Option<&'a [(usize, f64)]>,
}

impl Readings<'_> {
    /// Position of a joint in rad, mirrored if there is a mirror map.
    pub fn joint_position(&self, joint: usize) -> f64 {
        self.seen(self.position, joint)
    }

    /// Velocity of a joint in rad/s, mirrored if there is a mirror map.
    pub fn joint_velocity(&self, joint: usize) -> f64 {
        self.seen(self.velocity, joint)
    }

    fn seen(&self, vector: &[f64], joint: usize) -> f64 {
        match self.mirror {
            Some(mirror) => mirror[joint].1 * vector[mirror[joint].0],
            None => vector[joint],
        }
    }
}

/// One number of the observation: the policy gets `clamp((raw - offset) / scale, -clip, clip)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// The quantity (`joint_position`, `phase_sin`).
    pub name: String,
    /// The joint it belongs to.
    pub joint: Option<String>,
    /// SI unit of the raw value.
    pub unit: String,
    /// Raw value that is normalised to 0.
    pub offset: f64,
    /// Raw difference that is normalised to 1.
    pub scale: f64,
    /// Bound on the normalised value.
    pub clip: f64,
}

/// Every observation kind, in the order of the vector.
pub static KINDS: &[&ObserveKind] = &[
    &ObserveKind::of::<base_orientation::BaseOrientation>(),
    &ObserveKind::of::<joint_position::JointPosition>(),
    &ObserveKind::of::<joint_velocity::JointVelocity>(),
    &ObserveKind::of::<phase::Phase>(),
    &ObserveKind::of::<command::CommandSpeed>(),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

terms! {
    /// The policy's inputs.
    pub struct Observations in "observe", "observation";
}

/// Repeats a list of scales up to `count` numbers: one number applies to all, one leg's numbers apply to both
/// legs.
fn spread(scales: &[f64], count: usize) -> Vec<f64> {
    scales.iter().copied().cycle().take(count).collect()
}

/// Assigns a list of scales to the joints of a robot. Six numbers are those of hip yaw, hip roll, hip pitch,
/// knee, ankle pitch and ankle roll, whatever the robot's joint order; for a robot without such legs they are
/// repeated.
fn spread_over_joints(scales: &[f64], robot: &Robot) -> Vec<f64> {
    let mut spread = spread(scales, robot.joints());
    if scales.len() == 6 && scales.len() < spread.len() {
        for leg in [0, 1].iter().filter_map(|side| Leg::of(robot, *side)) {
            leg.joints().iter().zip(scales).for_each(|((joint, _), scale)| spread[*joint] = *scale);
        }
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;

    #[test]
    fn six_scales_go_to_the_joints_of_their_function_whatever_the_robot_s_order() {
        let scales = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let spread = |name: &str| {
            let robot = robot(name);
            let names: Vec<String> = robot.links.iter().map(|link| link.joint.name.clone()).collect();
            names.into_iter().zip(spread_over_joints(&scales, &robot)).collect::<Vec<_>>()
        };
        for (joint, scale) in spread("g1") {
            let expected = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"]
                .iter()
                .position(|function| joint.contains(function))
                .expect("a joint of a leg");
            assert_eq!(scale, scales[expected], "{joint}");
        }
        for (index, (_, scale)) in spread("tocabi").into_iter().enumerate() {
            assert_eq!(scale, scales[index % 6]);
        }
    }
}
