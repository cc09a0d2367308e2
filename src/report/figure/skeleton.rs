//! Stick figures: the places of base, joints and soles in the side view (x forward, z up).

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};

use crate::robot::Robot;

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
    /// From the base origin down the left and the right leg to the heel, then along the sole to the toe.
    pub legs: [Vec<[f64; 2]>; 2],
}

/// The stick figure of a posture. The trunk is drawn to twice the height of the base body's centre of mass.
pub fn skeleton(robot: &Robot, posture: &Posture) -> Skeleton {
    let [w, x, y, z] = posture.base_orientation;
    let base = Isometry3::from_parts(
        Translation3::from(Vector3::from(posture.base_position)),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    );
    let frames = link_frames(robot, &base, posture.position);
    let side = |point: Point3<f64>| [point.x, point.z];
    let crown = base * Point3::new(0.0, 0.0, (2.0 * robot.base.com.z).clamp(0.3, 0.8));
    let leg = |foot: usize| {
        let foot = &robot.feet[foot];
        let mut joints = vec![];
        let mut link = Some(foot.link);
        while let Some(index) = link {
            joints.push(side(Point3::from(frames[index].translation.vector)));
            link = robot.links[index].parent;
        }
        joints.push(side(Point3::from(base.translation.vector)));
        joints.reverse();
        for end in [-1.0, 1.0] {
            let corner = Point3::new(foot.centre.x + end * foot.half_extents.x, foot.centre.y, foot.sole());
            joints.push(side(frames[foot.link] * corner));
        }
        joints
    };
    Skeleton { trunk: vec![side(Point3::from(base.translation.vector)), side(crown)], legs: [leg(0), leg(1)] }
}

/// Poses of all links in the world.
fn link_frames(robot: &Robot, base: &Isometry3<f64>, position: &[f64]) -> Vec<Isometry3<f64>> {
    let mut frames: Vec<Isometry3<f64>> = Vec::with_capacity(robot.links.len());
    for (link, angle) in robot.links.iter().zip(position) {
        let parent = link.parent.map_or(*base, |index| frames[index]);
        frames.push(parent * link.joint.origin * turn(&link.joint.axis, *angle));
    }
    frames
}

fn turn(axis: &Unit<Vector3<f64>>, angle: f64) -> UnitQuaternion<f64> {
    let part = axis.into_inner() * libm::sin(0.5 * angle);
    UnitQuaternion::from_quaternion(Quaternion::from_parts(libm::cos(0.5 * angle), part))
}
