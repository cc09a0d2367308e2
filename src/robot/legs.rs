//! The joints of a leg by function, the leg's length, and its inverse kinematics.
//!
//! A leg is the chain from the base to a foot without shared joints such as a waist. Offsets and joint order
//! are arbitrary: functions are derived from the axes, and the inverse kinematics is numeric.

use nalgebra::{Isometry3, Matrix3, Matrix6, Matrix6xX, Vector3, Vector6};

use super::kinematics::Kinematics;
use super::model::Robot;

/// Minimum cosine of the angle between a joint's axis and a coordinate axis that it turns about; above 0.71,
/// at most one axis qualifies.
const ALONG: f64 = 0.75;

/// A joint of a leg and the sign of its axis along the base's x (roll), y (pitch) or z (yaw) when all
/// joints are at zero.
pub type Hinge = (usize, f64);

/// The joints of a leg with six joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Hip yaw.
    pub hip_yaw: Hinge,
    /// Hip roll.
    pub hip_roll: Hinge,
    /// Hip pitch.
    pub hip_pitch: Hinge,
    /// Knee, a pitch joint.
    pub knee: Hinge,
    /// Ankle pitch.
    pub ankle_pitch: Hinge,
    /// Ankle roll.
    pub ankle_roll: Hinge,
}

impl Leg {
    /// The left (0) or right (1) leg of a robot; `None` unless it has one yaw, two roll and three pitch
    /// joints.
    pub fn of(robot: &Robot, side: usize) -> Option<Self> {
        let [rolls, pitches, yaws] = [0, 1, 2].map(|axis| hinges(robot, side, axis));
        match (rolls.as_slice(), pitches.as_slice(), yaws.as_slice()) {
            ([hip_roll, ankle_roll], [hip_pitch, knee, ankle_pitch], [hip_yaw]) => Some(Self {
                hip_yaw: *hip_yaw,
                hip_roll: *hip_roll,
                hip_pitch: *hip_pitch,
                knee: *knee,
                ankle_pitch: *ankle_pitch,
                ankle_roll: *ankle_roll,
            }),
            _ => None,
        }
    }

    /// Hip, knee and ankle pitch of any leg: its first three pitch joints from the hip down.
    pub fn pitches(robot: &Robot, side: usize) -> Option<[Hinge; 3]> {
        hinges(robot, side, 1).first_chunk().copied()
    }

    /// The joints in the order hip yaw, roll, pitch, knee, ankle pitch, roll.
    pub fn joints(&self) -> [Hinge; 6] {
        [self.hip_yaw, self.hip_roll, self.hip_pitch, self.knee, self.ankle_pitch, self.ankle_roll]
    }
}

/// The joints of a leg, from the hip down, whose axis is within 41 degrees of a coordinate axis of the base
/// with all joints at zero: the hip pitch axes of humanoids are inclined by up to 35 degrees.
fn hinges(robot: &Robot, side: usize, axis: usize) -> Vec<Hinge> {
    let kinematics = at_zero(robot);
    let along = |joint: usize| kinematics.axis(joint)[axis];
    let mut hinges: Vec<Hinge> = own(&kinematics, side)
        .into_iter()
        .filter(|joint| along(*joint).abs() > ALONG)
        .map(|joint| (joint, along(joint).signum()))
        .collect();
    hinges.reverse();
    hinges
}

/// A joint of the left leg that turns about no axis of the base with all joints at zero, and its angle in rad
/// to the nearest.
pub fn oblique(robot: &Robot) -> Option<(String, f64)> {
    let kinematics = at_zero(robot);
    let mut leg = own(&kinematics, 0);
    leg.reverse();
    let along = |joint: usize| kinematics.axis(joint).amax();
    let joint = leg.into_iter().find(|joint| along(*joint) <= ALONG)?;
    Some((robot.links[joint].joint.name.clone(), libm::acos(along(joint))))
}

/// The joints of a leg from the foot up: those between base and foot that do not also carry the other foot.
pub fn own(kinematics: &Kinematics, side: usize) -> Vec<usize> {
    let other: Vec<usize> = kinematics.chain(kinematics.foot_link(1 - side)).collect();
    kinematics.chain(kinematics.foot_link(side)).filter(|joint| !other.contains(joint)).collect()
}

/// The kinematics with all joints at zero and the base at the origin.
fn at_zero(robot: &Robot) -> Kinematics {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    kinematics
}

/// Length of a leg in m: height of the hip pitch joint above the foot's link (the ankle) with all joints at
/// zero. `None` without a pitch joint.
pub fn leg_length(robot: &Robot) -> Option<f64> {
    let (hip, _) = *hinges(robot, 0, 1).first()?;
    let kinematics = at_zero(robot);
    Some(kinematics.pose(hip).translation.z - kinematics.pose(robot.feet[0].link).translation.z)
}

/// Height in m of the hips' pitch axes above the lower sole in the default pose, base upright: independent of
/// the base's origin. Without pitch joints, that of the joints next to the base.
pub fn hip_height(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    let ground =
        [0, 1].map(|side| kinematics.sole(side).translation.z).into_iter().fold(f64::INFINITY, f64::min);
    let hips = [0, 1].map(|side| {
        let pitch = hinges(robot, side, 1).first().map(|(joint, _)| *joint);
        pitch.or_else(|| own(&kinematics, side).last().copied()).unwrap_or(robot.feet[side].link)
    });
    let height = |joint: usize| kinematics.pose(joint).translation.z - ground;
    0.5 * (height(hips[0]) + height(hips[1]))
}

/// Moves the joints of a leg until its foot's link has the target pose (base frame), starting from
/// `position`, by damped Newton steps. Returns the remaining error (m and rad combined).
pub fn reach(kinematics: &mut Kinematics, side: usize, target: &Isometry3<f64>, position: &mut [f64]) -> f64 {
    let foot = kinematics.foot_link(side);
    let chain = own(kinematics, side);
    let mut residual = f64::INFINITY;
    for _ in 0..100 {
        kinematics.place(&Isometry3::identity(), position);
        let error = pose_error(kinematics.pose(foot), target);
        residual = error.norm();
        if residual < 1e-13 {
            break;
        }
        let jacobian = leg_jacobian(kinematics, foot, &chain);
        // Levenberg-Marquardt with damping that vanishes with the error: it shortens steps far from the
        // target and preserves quadratic convergence near it.
        let damping = (1e-2 * residual * residual).max(1e-18);
        let normal: Matrix6<f64> = &jacobian * jacobian.transpose() + Matrix6::from_diagonal_element(damping);
        let Some(factor) = normal.cholesky() else { break };
        let step = jacobian.transpose() * factor.solve(&error);
        let shorten = (0.3 / step.amax().max(1e-300)).min(1.0);
        for (joint, change) in chain.iter().zip(step.iter()) {
            position[*joint] += shorten * change;
        }
    }
    residual
}

/// Displacement and rotation from one pose to another. The rotation is the antisymmetric part of the matrix,
/// because its logarithm is NaN close to the identity.
fn pose_error(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Vector6<f64> {
    let shift = to.translation.vector - from.translation.vector;
    let turn: Matrix3<f64> = (to.rotation * from.rotation.inverse()).to_rotation_matrix().into_inner();
    let vee = Vector3::new(turn.m32 - turn.m23, turn.m13 - turn.m31, turn.m21 - turn.m12) * 0.5;
    Vector6::new(shift.x, shift.y, shift.z, vee.x, vee.y, vee.z)
}

/// Jacobian (6 x chain; linear rows first) of the foot's link origin over the joints of a leg.
fn leg_jacobian(kinematics: &Kinematics, foot: usize, chain: &[usize]) -> Matrix6xX<f64> {
    let tip = kinematics.pose(foot).translation.vector;
    let mut jacobian = Matrix6xX::zeros(chain.len());
    for (column, joint) in chain.iter().enumerate() {
        let axis = kinematics.axis(*joint);
        let linear = axis.cross(&(tip - kinematics.pose(*joint).translation.vector));
        jacobian.fixed_view_mut::<3, 1>(0, column).copy_from(&linear);
        jacobian.fixed_view_mut::<3, 1>(3, column).copy_from(axis);
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;
    use crate::stream::Stream;

    #[test]
    fn functions_of_joints_come_from_their_axes() {
        let index = |leg: Leg| leg.joints().map(|(joint, _)| joint);
        assert_eq!(index(Leg::of(&robot("tocabi"), 1).unwrap()), [6, 7, 8, 9, 10, 11]);
        assert_eq!(
            index(Leg::of(&robot("g1"), 0).unwrap()),
            [2, 1, 0, 3, 4, 5],
            "pitch, roll, yaw, knee, ankle"
        );
    }

    #[test]
    fn leg_lengths_are_thigh_and_shank() {
        assert!((leg_length(&robot("tocabi")).unwrap() - 0.70).abs() < 1e-12);
        assert!((leg_length(&robot("atlas")).unwrap() - 0.796).abs() < 1e-12);
    }

    #[test]
    fn a_foot_reaches_a_pose_that_a_leg_had() {
        let mut stream = Stream::new("test/reach");
        for name in ["tocabi", "atlas", "g1"] {
            let robot = robot(name);
            let mut kinematics = Kinematics::new(&robot);
            for side in 0..2 {
                let goal: Vec<f64> = robot.default_pose().iter().map(|q| q + 0.1 * stream.normal()).collect();
                kinematics.place(&Isometry3::identity(), &goal);
                let target = *kinematics.pose(robot.feet[side].link);
                let mut position = robot.default_pose();
                assert!(reach(&mut kinematics, side, &target, &mut position) < 1e-12, "{name}");
                for joint in 0..6 {
                    assert!(
                        (position[6 * side + joint] - goal[6 * side + joint]).abs() < 1e-9,
                        "{name} {joint}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_pose_already_there_is_a_solution_and_not_a_nan() {
        let robot = robot("atlas");
        let mut kinematics = Kinematics::new(&robot);
        let target = *kinematics.pose(5);
        let mut position = robot.default_pose();
        assert!(reach(&mut kinematics, 0, &target, &mut position) < 1e-12);
        assert!(position.iter().zip(robot.default_pose()).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn a_pose_out_of_reach_leaves_a_residual() {
        let robot = robot("tocabi");
        let mut kinematics = Kinematics::new(&robot);
        let target = Isometry3::translation(0.1, 0.1, -1.2);
        let mut position = robot.default_pose();
        assert!(reach(&mut kinematics, 0, &target, &mut position) > 0.1);
    }
}
