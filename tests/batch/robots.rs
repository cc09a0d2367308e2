//! Robots for the tests of the batch engine.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use specforge::robot::model::Body;
use specforge::robot::{self, Robot, Shape};
use specforge::stream::Stream;

pub fn shipped() -> Vec<Robot> {
    robot::names().map(|name| robot::shipped(name).expect("it is shipped")).collect()
}

/// A robot with every figure changed by up to 30 %, its legs by up to 10 %, its feet with a grip of their
/// own.
pub fn drawn(name: &str, number: usize) -> Robot {
    let mut robot = robot::shipped(name).expect("it is shipped");
    let mut stream = Stream::new(&format!("test/batch/drawn/{name}/{number}"));
    robot.stretch_legs(0.9 + 0.2 * stream.uniform());
    let mut factor = || 0.7 + 0.6 * stream.uniform();
    for body in bodies(&mut robot) {
        body.mass *= factor();
        body.inertia *= factor();
        body.com *= factor();
    }
    for joint in robot.links.iter_mut().map(|link| &mut link.joint) {
        for figure in [&mut joint.damping, &mut joint.friction, &mut joint.armature, &mut joint.effort_limit]
        {
            *figure *= factor();
        }
    }
    robot.feet[1].friction = factor();
    robot.base.load(3.0, nalgebra::Point3::new(0.1, 0.0, 0.3));
    robot
}

fn bodies(robot: &mut Robot) -> impl Iterator<Item = &mut Body> {
    std::iter::once(&mut robot.base).chain(robot.links.iter_mut().map(|link| &mut link.body))
}

/// A robot with a shape of another kind on every link that has none, and skew joints.
pub fn decorated(name: &str) -> Robot {
    let mut robot = robot::shipped(name).expect("it is shipped");
    let shapes = [
        Shape::Cylinder(0.07, 0.05),
        Shape::Sphere(0.07),
        Shape::Capsule(0.06, 0.04),
        Shape::Box(Vector3::new(0.05, 0.06, 0.07)),
    ];
    let feet = robot.feet.clone().map(|foot| foot.link);
    for (index, link) in robot.links.iter_mut().enumerate().filter(|(index, _)| !feet.contains(index)) {
        let turn = UnitQuaternion::from_euler_angles(0.3 * index as f64, 0.5, -0.2 * index as f64);
        let pose = Isometry3::from_parts(nalgebra::Translation3::new(0.01, 0.0, -0.02), turn);
        link.body.collisions.push(specforge::robot::Collision { shape: shapes[index % 4].clone(), pose });
        let skew = UnitQuaternion::from_euler_angles(0.02, -0.03, 0.01 * index as f64);
        link.joint.axis = skew * link.joint.axis;
    }
    robot
}
