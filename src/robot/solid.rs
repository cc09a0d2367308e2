//! Collision shapes as solids of the geometry library, in f32.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::shape::SharedShape;

use super::model::{Collision, Foot, Shape};

/// The solid of a collision shape and its pose in the body frame.
pub fn solid(collision: &Collision) -> (SharedShape, Isometry3<f64>) {
    let upright = collision.pose;
    match &collision.shape {
        Shape::Box(half) => (SharedShape::cuboid(half.x as f32, half.y as f32, half.z as f32), upright),
        Shape::Capsule(half, radius) => (SharedShape::capsule_z(*half as f32, *radius as f32), upright),
        Shape::Sphere(radius) => (SharedShape::ball(*radius as f32), upright),
        // The library's cylinder is along y.
        Shape::Cylinder(half, radius) => {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
            (SharedShape::cylinder(*half as f32, *radius as f32), upright * turn)
        }
    }
}

/// The box of a sole and its pose in the link frame.
pub fn sole(foot: &Foot) -> (SharedShape, Isometry3<f64>) {
    let half = foot.half_extents;
    let place = Isometry3::translation(foot.centre.x, foot.centre.y, foot.centre.z);
    (SharedShape::cuboid(half.x as f32, half.y as f32, half.z as f32), place)
}

/// Converts a pose to the library's type.
pub fn pose(from: &Isometry3<f64>) -> Pose {
    let turn = from.rotation.coords;
    let turn = Rotation::from_xyzw(turn.x as f32, turn.y as f32, turn.z as f32, turn.w as f32).normalize();
    let place = from.translation.vector;
    Pose::from_parts(Vector::new(place.x as f32, place.y as f32, place.z as f32), turn)
}
