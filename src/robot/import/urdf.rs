//! URDF: links and joints, inertials, limits, dynamics and collision primitives.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, JointType, Pose};

use super::tree::{Hinge, Part, Tree, cylinder, massless};
use crate::robot::{Body, Collision, Shape};

/// The tree of a URDF text. `Err` says why it is none.
pub(super) fn tree(text: &str) -> Result<Tree, String> {
    let robot = urdf_rs::read_from_string(text).map_err(|error| error.to_string())?;
    let mut tree = Tree { name: robot.name.clone(), format: "URDF", ..Tree::default() };
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
    let mut roots = robot.links.iter().filter(|link| !is_child(&link.name));
    let (Some(root), None) = (roots.next(), roots.next()) else {
        return Err("a robot is one tree: exactly one link may have no parent".to_owned());
    };
    let mut open = vec![(root.name.clone(), None, None)];
    while let Some((name, parent, joint)) = open.pop() {
        let Some(link) = robot.links.iter().find(|link| link.name == name) else {
            return Err(format!("a joint names the link `{name}`, and there is none"));
        };
        if tree.parts.len() > robot.links.len() {
            return Err("the joints form a circle".to_owned());
        }
        let index = tree.parts.len();
        let body = body(link, &mut tree.notes);
        let (pose, hinge) = match joint {
            Some(joint) => (isometry(&joint_of(&robot, joint).origin), hinge(joint_of(&robot, joint), &mut tree.notes)),
            None => (Isometry3::identity(), None),
        };
        tree.parts.push(Part { body, parent, pose, hinge });
        // Depth first, in the order of the file.
        let children = robot.joints.iter().enumerate().filter(|(_, joint)| joint.parent.link == name);
        let children: Vec<_> = children.map(|(at, joint)| (joint.child.link.clone(), Some(index), Some(at))).collect();
        open.extend(children.into_iter().rev());
    }
    Ok(tree)
}

fn joint_of(robot: &urdf_rs::Robot, index: usize) -> &urdf_rs::Joint {
    &robot.joints[index]
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = pose.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(pose.xyz.0)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

fn body(link: &urdf_rs::Link, notes: &mut Vec<String>) -> Body {
    let inertial = &link.inertial;
    let i = &inertial.inertia;
    let own = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let pose = isometry(&inertial.origin);
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    let mut body = massless(&link.name);
    body.mass = inertial.mass.value;
    body.com = Point3::from(pose.translation.vector);
    body.inertia = turn * own * turn.transpose();
    body.collisions = link.collision.iter().filter_map(|collision| shape(&link.name, collision, notes)).collect();
    body
}

fn shape(link: &str, collision: &urdf_rs::Collision, notes: &mut Vec<String>) -> Option<Collision> {
    let pose = isometry(&collision.origin);
    let shape = match &collision.geometry {
        Geometry::Box { size } => Shape::Box(0.5 * Vector3::from(size.0)),
        Geometry::Capsule { radius, length } => Shape::Capsule(0.5 * length, *radius),
        Geometry::Sphere { radius } => Shape::Sphere(*radius),
        Geometry::Cylinder { radius, length } => {
            notes.push(format!("`{link}`: a cylinder became the capsule that lies inside it"));
            return Some(cylinder(0.5 * length, *radius, pose));
        }
        Geometry::Mesh { filename, .. } => {
            notes.push(format!("`{link}`: the mesh {filename} is left out; give the body a box or capsules instead"));
            return None;
        }
    };
    Some(Collision { shape, pose })
}

fn hinge(joint: &urdf_rs::Joint, notes: &mut Vec<String>) -> Option<Hinge> {
    let other = match joint.joint_type {
        JointType::Fixed => return None,
        JointType::Revolute | JointType::Continuous => None,
        JointType::Prismatic => Some("prismatic"),
        JointType::Floating => Some("floating"),
        JointType::Planar => Some("planar"),
        JointType::Spherical => Some("spherical"),
    };
    if joint.mimic.is_some() {
        notes.push(format!("joint `{}` mimics another one, which a robot file cannot say", joint.name));
    }
    let given = |value: f64| (value.is_finite() && value > 0.0).then_some(value);
    let bounded = |value: f64| (joint.joint_type == JointType::Revolute && value.is_finite()).then_some(value);
    Some(Hinge {
        name: joint.name.clone(),
        other: other.map(str::to_owned),
        axis: Unit::try_new(Vector3::from(joint.axis.xyz.0), 1e-9),
        lower: bounded(joint.limit.lower),
        upper: bounded(joint.limit.upper),
        effort_limit: given(joint.limit.effort),
        velocity_limit: given(joint.limit.velocity),
        damping: joint.dynamics.as_ref().map(|dynamics| dynamics.damping),
        friction: joint.dynamics.as_ref().map(|dynamics| dynamics.friction),
        ..Hinge::default()
    })
}
