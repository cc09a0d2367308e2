//! Stick figures: base, joints and soles in the side view (x forward, z up).

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::robot::{Kinematics, Robot};

/// A robot's posture in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture<'a> {
    /// Position of the base origin in m.
    pub base_position: [f64; 3],
    /// Orientation of the base, unit quaternion w x y z.
    pub base_orientation: [f64; 4],
    /// Joint positions in rad.
    pub position: &'a [f64],
}

/// Polylines of a stick figure, as x and z in m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// From the base origin up the trunk.
    pub trunk: Vec<[f64; 2]>,
    /// From the base origin down the left and the right leg, then along the sole from heel to toe.
    pub legs: [Vec<[f64; 2]>; 2],
}

/// Height of the crown above the base origin in m: twice the height of the base body's centre of mass, which
/// includes the welded upper body.
pub fn crown(robot: &Robot) -> f64 {
    (2.0 * robot.base.com.z).clamp(0.3, 0.8)
}

/// The stick figure of a posture.
pub fn skeleton(robot: &Robot, posture: &Posture) -> Skeleton {
    let [w, x, y, z] = posture.base_orientation;
    let base = Isometry3::from_parts(
        Translation3::from(Vector3::from(posture.base_position)),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    );
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&base, posture.position);
    let side = |point: Point3<f64>| [point.x, point.z];
    let origin = |pose: &Isometry3<f64>| side(Point3::from(pose.translation.vector));
    let leg = |foot: usize| {
        let foot = &robot.feet[foot];
        let mut chain = vec![foot.link];
        while let Some(parent) = robot.links[chain[chain.len() - 1]].parent {
            chain.push(parent);
        }
        let joints = chain.iter().rev().map(|link| origin(kinematics.pose(*link)));
        let ends = [-1.0, 1.0].map(|end| {
            let corner = Point3::new(foot.centre.x + end * foot.half_extents.x, foot.centre.y, foot.sole());
            side(kinematics.pose(foot.link) * corner)
        });
        [origin(&base)].into_iter().chain(joints).chain(ends).collect()
    };
    let top = side(base * Point3::new(0.0, 0.0, crown(robot)));
    Skeleton { trunk: vec![origin(&base), top], legs: [leg(0), leg(1)] }
}
