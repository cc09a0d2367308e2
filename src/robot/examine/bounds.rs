//! E0424: values beyond those of any machine. They indicate a wrong unit or a placeholder, and overflow in
//! training.

use nalgebra::Vector3;

use super::size::bodies;
use super::{Examined, Outlier, path_of, worst};
use crate::robot::checks::Issue;
use crate::robot::model::{Body, Joint, Robot, Shape};

/// The code of these findings.
pub const CODE: &str = "E0424";

/// A joint parameter with its maximum.
struct Bound {
    key: &'static str,
    of: fn(&Joint) -> f64,
    most: f64,
    unit: &'static str,
    help: &'static str,
}

/// Hydraulic joints of the largest walking machines have 1e4 N m, and TOCABI's rotors 1.1 kg m^2. Each bound
/// is at least ten times the largest known value.
const JOINT: [Bound; 9] = [
    Bound {
        key: "effort_limit",
        of: |joint| joint.effort_limit,
        most: 1e5,
        unit: "N m",
        help: "write the largest torque of the drive in N m: torque actions are scaled by it",
    },
    Bound {
        key: "velocity_limit",
        of: |joint| joint.velocity_limit,
        most: 1e4,
        unit: "rad/s",
        help: "write the speed limit of the joint in rad/s, at the output of its gear",
    },
    Bound {
        key: "damping",
        of: |joint| joint.damping,
        most: 1e4,
        unit: "N m s/rad",
        help: "write the viscous damping of the joint in N m s/rad",
    },
    Bound {
        key: "friction",
        of: |joint| joint.friction,
        most: 1e5,
        unit: "N m",
        help: "write the Coulomb friction of the joint in N m",
    },
    Bound {
        key: "armature",
        of: |joint| joint.armature,
        most: 1e3,
        unit: "kg m^2",
        help: "write the rotor's inertia times the square of the gear ratio in kg m^2",
    },
    Bound {
        key: "stiffness_gain",
        of: |joint| joint.stiffness_gain,
        most: 1e6,
        unit: "N m/rad",
        help: "write the proportional gain in N m/rad",
    },
    Bound {
        key: "damping_gain",
        of: |joint| joint.damping_gain,
        most: 1e5,
        unit: "N m s/rad",
        help: "write the derivative gain in N m s/rad",
    },
    Bound { key: "lower", of: |joint| joint.lower.abs(), most: 1e3, unit: "rad", help: TURNS },
    Bound { key: "upper", of: |joint| joint.upper.abs(), most: 1e3, unit: "rad", help: TURNS },
];

const TURNS: &str = "write the range that the joint may use in rad: positions are commanded within it";

/// Largest mass of a body in kg: ten times the heaviest walking machines.
pub const MASS: f64 = 1e5;
/// Largest moment of inertia in kg m^2: that of the heaviest body at 10 m.
pub const INERTIA: f64 = 1e7;
/// Largest length in m.
pub const LENGTH: f64 = 100.0;

/// No value exceeds its bound.
pub fn check(robot: &Robot) -> Examined {
    let joints = || robot.links.iter().enumerate().map(|(index, link)| (index, &link.joint));
    let mut issues: Vec<Issue> = JOINT.iter().filter_map(|bound| bound.beyond(joints())).collect();
    issues.extend(of_bodies(robot, "mass", MASS, "kg", |body| body.mass));
    issues.extend(of_bodies(robot, "inertia", INERTIA, "kg m^2", |body| body.inertia.amax()));
    issues.extend(lengths(robot));
    let strongest = joints().map(|(_, joint)| joint.effort_limit).fold(0.0, f64::max);
    Examined {
        name: "every figure is one that a machine can have",
        detail: format!("{} joints of up to {strongest} N m", robot.joints()),
        issues,
    }
}

impl Bound {
    fn beyond<'a>(&self, joints: impl Iterator<Item = (usize, &'a Joint)>) -> Option<Issue> {
        let Self { key, of, most, unit, help } = self;
        let found = joints.filter(|(_, joint)| of(joint) > *most).map(|(index, joint)| Outlier {
            excess: of(joint),
            path: format!("links.{index}.joint.{key}"),
            message: format!(
                "`{key}` of joint `{}` is {:e} {unit}, more than {most:e} {unit}",
                joint.name,
                of(joint)
            ),
        });
        worst(CODE, found.collect(), "joints", help)
    }
}

fn of_bodies(robot: &Robot, key: &str, most: f64, unit: &str, of: impl Fn(&Body) -> f64) -> Option<Issue> {
    let found = bodies(robot).filter(|(_, body)| of(body) > most).map(|(index, body)| Outlier {
        excess: of(body),
        path: format!("{}.{key}", path_of(index)),
        message: format!("the {key} of `{}` is {:e} {unit}, more than {most:e} {unit}", body.name, of(body)),
    });
    worst(CODE, found.collect(), "bodies", &format!("write it in {unit}"))
}

/// Lengths of bodies, joints and soles.
fn lengths(robot: &Robot) -> Option<Issue> {
    let mut found = Vec::new();
    let mut measure = |length: f64, path: String, what: String| {
        if length > LENGTH {
            let message = format!("{what} is {length:e} m, more than {LENGTH} m");
            found.push(Outlier { excess: length, path, message });
        }
    };
    let far = |vector: &Vector3<f64>| vector.amax();
    for (index, body) in bodies(robot) {
        let (path, name) = (path_of(index), &body.name);
        let away = far(&body.com.coords);
        measure(
            away,
            format!("{path}.com"),
            format!("the distance of the centre of mass of `{name}` from its frame"),
        );
        for (at, collision) in body.collisions.iter().enumerate() {
            let size = match &collision.shape {
                Shape::Box(half) => far(half),
                Shape::Capsule(half, radius) | Shape::Cylinder(half, radius) => half.max(*radius),
                Shape::Sphere(radius) => *radius,
            };
            let size = size.max(far(&collision.pose.translation.vector));
            measure(size, format!("{path}.collisions.{at}"), format!("a collision shape of `{name}`"));
        }
    }
    for (index, link) in robot.links.iter().enumerate() {
        let joint = &link.joint;
        let away = far(&joint.origin.translation.vector);
        measure(away, format!("links.{index}.joint.origin"), format!("the offset of joint `{}`", joint.name));
    }
    for (side, foot) in ["left", "right"].iter().zip(&robot.feet) {
        let size = far(&foot.half_extents).max(far(&foot.centre.coords));
        measure(size, format!("feet.{side}"), format!("the {side} sole"));
    }
    worst(CODE, found, "lengths", "write lengths in m: multiply those of a file in millimetres by 0.001")
}
