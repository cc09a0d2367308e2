//! The elements and attributes of URDF 1.0 to 1.2 and of its Gazebo, ROS and Bullet extensions, classified.

use super::table::Class::{Harmless, Imported, Left};
use super::table::Group::{Limits, Simulators, Solver, Springs};
use super::table::{Row, row, whole};

/// Elements of which only the first in its parent counts.
pub(super) const SINGLE: &[&str] = &[
    "inertial",
    "origin",
    "mass",
    "inertia",
    "geometry",
    "parent",
    "child",
    "axis",
    "limit",
    "dynamics",
    "mimic",
    "safety_controller",
];

pub(crate) const TABLE: &[Row] = &[
    row("robot", &[(Imported, "name, version")]),
    whole("robot/material", Harmless),
    whole("robot/sensor", Harmless),
    whole("robot/gazebo", Left(Simulators)),
    whole("robot/transmission", Left(Simulators)),
    whole("robot/ros2_control", Left(Simulators)),
    whole("robot/mujoco", Left(Simulators)),
    row("robot/link", &[(Imported, "name"), (Harmless, "type")]),
    whole("robot/link/visual", Harmless),
    whole("robot/link/sensor", Harmless),
    whole("robot/link/contact", Left(Solver)),
    row("robot/link/inertial", &[]),
    row("robot/link/inertial/origin", &[(Imported, "xyz, rpy, quat_xyzw")]),
    row("robot/link/inertial/mass", &[(Imported, "value")]),
    row("robot/link/inertial/inertia", &[(Imported, "ixx, ixy, ixz, iyy, iyz, izz")]),
    row("robot/link/collision", &[(Harmless, "name, group")]),
    row("robot/link/collision/origin", &[(Imported, "xyz, rpy, quat_xyzw")]),
    whole("robot/link/collision/material", Harmless),
    whole("robot/link/collision/verbose", Harmless),
    whole("robot/link/collision/contact_coefficients", Left(Solver)),
    row("robot/link/collision/geometry", &[(Harmless, "name")]),
    row("robot/link/collision/geometry/box", &[(Imported, "size")]),
    row("robot/link/collision/geometry/capsule", &[(Imported, "radius, length")]),
    row("robot/link/collision/geometry/cylinder", &[(Imported, "radius, length")]),
    row("robot/link/collision/geometry/sphere", &[(Imported, "radius")]),
    row("robot/link/collision/geometry/mesh", &[(Imported, "filename, scale")]),
    row("robot/joint", &[(Imported, "name, type")]),
    row("robot/joint/origin", &[(Imported, "xyz, rpy, quat_xyzw")]),
    row("robot/joint/parent", &[(Imported, "link")]),
    row("robot/joint/child", &[(Imported, "link")]),
    row("robot/joint/axis", &[(Imported, "xyz")]),
    row(
        "robot/joint/limit",
        &[(Imported, "lower, upper, effort, velocity"), (Left(Limits), "acceleration, deceleration, jerk")],
    ),
    row(
        "robot/joint/dynamics",
        &[(Imported, "damping, friction"), (Left(Springs), "spring_stiffness=0, spring_reference=0")],
    ),
    row("robot/joint/mimic", &[(Imported, "joint, multiplier, offset")]),
    whole("robot/joint/calibration", Harmless),
    whole("robot/joint/safety_controller", Left(Limits)),
];

#[cfg(test)]
mod tests {
    use super::super::table::knows;
    use super::*;

    /// What the ROS parser reads (urdfdom, versions 1.0 to 1.2 of the format), one element per line.
    const KNOWN: &str = include_str!("urdf.txt");

    #[test]
    fn every_element_and_attribute_of_urdf_is_classified() {
        for line in KNOWN.lines().filter(|line| !line.starts_with('#')) {
            let (path, attributes) = line.split_once(':').expect("a line is `path: attributes`");
            assert!(knows(TABLE, path, None), "{path}");
            for attribute in attributes.split_whitespace() {
                assert!(knows(TABLE, path, Some(attribute)), "{attribute} of {path}");
            }
        }
        assert!(
            !knows(TABLE, "robot/joint/limit", Some("torque")) && !knows(TABLE, "robot/joint/spring", None)
        );
    }
}
