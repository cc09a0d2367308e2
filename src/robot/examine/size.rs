//! The size of a robot and its bodies, from joints, soles and shapes: the reference for all quantities that
//! depend on length.

use nalgebra::{Point3, Vector3};

use crate::robot::kinematics::Kinematics;
use crate::robot::model::{Body, Robot};
use crate::robot::solid::{pose, sole, solid};

/// Maximum distance in m between two joints or sole corners in the default pose. Shapes and centres of mass
/// are excluded, because they are compared with it.
pub fn reach(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    let joints = (0..robot.joints()).map(|joint| Point3::from(kinematics.pose(joint).translation.vector));
    let corners = (0..2).flat_map(|side| kinematics.corners(side));
    let points: Vec<Point3<f64>> = joints.chain(corners).chain([Point3::origin()]).collect();
    let apart = |a: &Point3<f64>| points.iter().map(|b| (a - b).norm()).fold(0.0, f64::max);
    points.iter().map(apart).fold(0.0, f64::max)
}

/// The base (0) and the links.
pub fn bodies(robot: &Robot) -> impl Iterator<Item = (usize, &Body)> {
    std::iter::once(&robot.base).chain(robot.links.iter().map(|link| &link.body)).enumerate()
}

/// The axis-aligned box in a body's frame around its origin, the joints it carries, its shapes and its sole.
pub struct Extent {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Extent {
    /// The box of the base (0) or a link (index from 1).
    pub fn of(robot: &Robot, body: usize) -> Self {
        let mut extent = Self { low: Vector3::zeros(), high: Vector3::zeros() };
        let carried = robot.links.iter().filter(|link| link.parent.map_or(0, |parent| parent + 1) == body);
        carried.for_each(|link| extent.add(&link.joint.origin.translation.vector));
        let own = bodies(robot)
            .filter(|(index, _)| *index == body)
            .flat_map(|(_, body)| &body.collisions)
            .map(solid);
        let soles = robot.feet.iter().filter(|foot| foot.link + 1 == body).map(sole);
        for (shape, place) in own.chain(soles) {
            let around = shape.compute_aabb(&pose(&place));
            for corner in [around.mins, around.maxs] {
                extent.add(&Vector3::new(f64::from(corner.x), f64::from(corner.y), f64::from(corner.z)));
            }
        }
        extent
    }

    fn add(&mut self, point: &Vector3<f64>) {
        (self.low, self.high) = (self.low.inf(point), self.high.sup(point));
    }

    /// Length of the box's diagonal in m.
    pub fn diagonal(&self) -> f64 {
        (self.high - self.low).norm()
    }

    /// Distance in m of a point in the body's frame from the box; 0 inside.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        (point.coords - point.coords.sup(&self.low).inf(&self.high)).norm()
    }
}
