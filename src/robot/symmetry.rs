//! The mirror map of a robot (reflection in the x-z plane), and its standing height: what follows from
//! the model's geometry and is not written in its file.

use nalgebra::{Isometry3, Vector3};

use super::kinematics::Kinematics;
use super::model::Robot;

/// Distance in m, and length of the difference of unit axes, up to which joints count as mirror images.
const TOLERANCE: f64 = 2e-3;

/// Mirror images of all joints: index and sign of the coordinate. A reflection turns a rotation about
/// `(x, y, z)` into one about `(-x, y, -z)`, so with like axes on both sides yaw and roll change sign and
/// pitch keeps it. The name of the first joint without an image is the error.
pub fn mirror_map(robot: &Robot) -> Result<Vec<(usize, f64)>, String> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let image = |index: usize| {
        let (position, axis) = (kinematics.pose(index).translation.vector, kinematics.axis(index));
        let position = Vector3::new(position.x, -position.y, position.z);
        let axis = Vector3::new(-axis.x, axis.y, -axis.z);
        (0..robot.joints()).find_map(|other| {
            let apart = (kinematics.pose(other).translation.vector - position).norm();
            let along = kinematics.axis(other).dot(&axis);
            (apart < TOLERANCE && (axis * along.signum() - kinematics.axis(other)).norm() < TOLERANCE)
                .then_some((other, along.signum()))
        })
    };
    (0..robot.joints()).map(|index| image(index).ok_or_else(|| robot.links[index].joint.name.clone())).collect()
}

/// Whether mirroring twice is the identity.
pub fn is_involution(mirror: &[(usize, f64)]) -> bool {
    mirror.iter().enumerate().all(|(index, &(image, sign))| mirror.get(image) == Some(&(index, sign)))
}

/// A joint vector's mirror image.
pub fn mirrored(mirror: &[(usize, f64)], vector: &[f64]) -> Vec<f64> {
    mirror.iter().map(|&(image, sign)| sign * vector[image]).collect()
}

/// Height in m of the base origin above flat ground on which the lower sole stands in the default
/// pose, base upright.
pub fn standing_height(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    -(0..2).map(|side| kinematics.sole(side).translation.z).fold(f64::INFINITY, f64::min)
}
