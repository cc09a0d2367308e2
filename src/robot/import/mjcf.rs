//! MJCF: bodies with their inertials, hinges, geoms, motors and the first keyframe.

use std::path::Path;

use mjcf_rs::body::{Geom, GeomType, InertiaSpec, Inertial, Joint, JointType};
use mjcf_rs::compiler::InertiaFromGeom;
use mjcf_rs::extras::{Actuator, ActuatorKind};
use mjcf_rs::{Model, Pose};
use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};

use super::tree::{Hinge, Part, Tree, cylinder, massless};
use crate::robot::{Body, Collision, Shape};

/// The tree of an MJCF file. `Err` says why it is none.
pub(super) fn tree(path: &Path) -> Result<Tree, String> {
    let model = Model::from_file(path).map_err(|error| error.to_string())?;
    let mut tree = Tree { name: model.name.clone().unwrap_or_default(), format: "MJCF", ..Tree::default() };
    let roots: Vec<usize> = children(&model, 0).collect();
    let floating = |id: &usize| model.bodies[*id].body.joints.iter().any(|joint| joint.type_ == JointType::Free);
    let root = match (roots.iter().find(|id| floating(id)), roots.as_slice()) {
        (Some(root), _) => *root,
        (None, [root]) => *root,
        _ => return Err("the robot's base is not clear: no body of the world has a free joint".to_owned()),
    };
    let mut open = vec![(root, None)];
    while let Some((id, parent)) = open.pop() {
        let index = tree.parts.len();
        let part = part(&model, id, parent, &mut tree.notes)?;
        tree.parts.push(part);
        let below: Vec<usize> = children(&model, id).collect();
        open.extend(below.into_iter().rev().map(|child| (child, Some(index))));
    }
    Ok(tree)
}

fn children(model: &Model, id: usize) -> impl Iterator<Item = usize> {
    model.bodies.iter().enumerate().filter(move |(_, entry)| entry.parent == Some(id)).map(|(child, _)| child)
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let (turn, place) = (pose.rotation, pose.translation);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(turn.w, turn.x, turn.y, turn.z));
    Isometry3::from_parts(Translation3::new(place.x, place.y, place.z), turn)
}

fn part(model: &Model, id: usize, parent: Option<usize>, notes: &mut Vec<String>) -> Result<Part, String> {
    let source = &model.bodies[id].body;
    let name = source.name.clone().unwrap_or_else(|| format!("body_{id}"));
    let mut body = body(model, &name, &source.inertial, notes);
    body.collisions = source.geoms.iter().filter_map(|geom| shape(&name, geom, notes)).collect();
    // The pose of the base in the world is that of a key frame, not of the robot.
    let pose = if parent.is_some() { isometry(&source.pose) } else { Isometry3::identity() };
    let moving: Vec<&Joint> = source.joints.iter().filter(|joint| joint.type_ != JointType::Free).collect();
    let hinge = match moving.as_slice() {
        [] => None,
        [joint] => Some(hinge(model, joint, &name)),
        joints => {
            return Err(format!(
                "body `{name}` has {} joints; give each its own body (a small mass between them), as a robot file has it",
                joints.len()
            ));
        }
    };
    Ok(Part { body, parent, pose, hinge })
}

fn body(model: &Model, name: &str, inertial: &Option<Inertial>, notes: &mut Vec<String>) -> Body {
    let mut body = massless(name);
    match inertial {
        Some(inertial) if model.compiler.inertia_from_geom != InertiaFromGeom::True => {
            let own = match inertial.inertia {
                InertiaSpec::Diagonal(diagonal) => Matrix3::from_diagonal(&Vector3::from(diagonal)),
                InertiaSpec::Full([xx, yy, zz, xy, xz, yz]) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            };
            let pose = isometry(&inertial.pose);
            let turn = pose.rotation.to_rotation_matrix().into_inner();
            body.mass = inertial.mass;
            body.com = Point3::from(pose.translation.vector);
            body.inertia = turn * own * turn.transpose();
        }
        _ => notes
            .push(format!("`{name}` has no inertial, its mass follows from its geoms: write mass, com and inertia")),
    }
    body
}

fn shape(body: &str, geom: &Geom, notes: &mut Vec<String>) -> Option<Collision> {
    if geom.contype == 0 && geom.conaffinity == 0 {
        return None;
    }
    let (mut pose, mut half_length) = (isometry(&geom.pose), geom.size[1]);
    if let Some([ax, ay, az, bx, by, bz]) = geom.fromto {
        let (from, to) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
        let along = Unit::try_new(to - from, 1e-12).unwrap_or_else(Vector3::z_axis);
        let turn = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &along)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        pose = Isometry3::from_parts(Translation3::from(0.5 * (from + to)), turn);
        half_length = 0.5 * (to - from).norm();
    }
    let shape = match geom.type_ {
        GeomType::Box => Shape::Box(Vector3::from(geom.size)),
        GeomType::Capsule => Shape::Capsule(half_length, geom.size[0]),
        GeomType::Sphere => Shape::Sphere(geom.size[0]),
        GeomType::Cylinder => {
            notes.push(format!("`{body}`: a cylinder became the capsule that lies inside it"));
            return Some(cylinder(half_length, geom.size[0], pose));
        }
        other => {
            let name = geom.mesh.as_ref().or(geom.name.as_ref()).map(|name| format!(" `{name}`")).unwrap_or_default();
            let kind = format!("{other:?}").to_lowercase();
            notes.push(format!("`{body}`: the {kind}{name} is left out; give the body a box or capsules instead"));
            return None;
        }
    };
    Some(Collision { shape, pose })
}

fn hinge(model: &Model, joint: &Joint, body: &str) -> Hinge {
    let name = joint.name.clone().unwrap_or_else(|| format!("{body}_joint"));
    let other = match joint.type_ {
        JointType::Hinge => None,
        JointType::Slide => Some("a slide"),
        JointType::Ball => Some("a ball"),
        JointType::Free => Some("free"),
    };
    let limited = joint.limited.resolve(model.compiler.autolimits, joint.range.is_some());
    let range = joint.range.filter(|_| limited);
    let actuators: Vec<&Actuator> =
        model.actuators.iter().filter(|actuator| actuator.joint.as_deref() == Some(&name)).collect();
    let position = actuators.iter().find(|actuator| actuator.kind == ActuatorKind::Position);
    Hinge {
        other: other.map(str::to_owned),
        anchor: Vector3::from(joint.pos),
        axis: Unit::try_new(Vector3::from(joint.axis), 1e-9),
        lower: range.map(|range| range[0]),
        upper: range.map(|range| range[1]),
        effort_limit: actuators.iter().find_map(|actuator| effort(actuator)),
        velocity_limit: None,
        damping: Some(joint.damping),
        friction: Some(joint.frictionloss),
        armature: Some(joint.armature),
        stiffness_gain: position.and_then(|actuator| actuator.kp),
        damping_gain: position.and_then(|actuator| actuator.kv),
        default_position: key_position(model, &name),
        name,
    }
}

/// Largest torque of a motor in N m: its force range, or its control range times the gear.
fn effort(actuator: &Actuator) -> Option<f64> {
    let [low, high] = match (actuator.force_range, actuator.kind) {
        (Some(range), _) => range,
        (None, ActuatorKind::Motor) => actuator.ctrl_range?.map(|bound| bound * actuator.gear[0]),
        _ => return None,
    };
    let limit = low.abs().min(high.abs());
    (limit > 0.0 && limit.is_finite()).then_some(limit)
}

/// Position of a joint in the first key frame.
fn key_position(model: &Model, name: &str) -> Option<f64> {
    let key = model.keyframes.first()?;
    let mut at = 0;
    for entry in &model.bodies {
        for joint in &entry.body.joints {
            if joint.name.as_deref() == Some(name) {
                return key.qpos.get(at).copied();
            }
            at += match joint.type_ {
                JointType::Hinge | JointType::Slide => 1,
                JointType::Ball => 4,
                JointType::Free => 7,
            };
        }
    }
    None
}
