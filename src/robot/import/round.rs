//! Round feet: balls, capsules and cylinders whose sole is replaced by a box, and wheels.

use nalgebra::Vector3;

use super::block::around;
use super::welded::Welded;
use crate::diag::Diagnostic;
use crate::robot::{Collision, Shape};

/// Share of the sole's box below which the contact with the ground is a point or a line.
const NARROW: f64 = 0.25;
/// Maximum deviation of a wheel from its joint's axis: sine of the angle, and offset relative to the radius.
const CENTRED: f64 = 0.1;

/// How shapes touch level ground if the contact is a point or a line: a clause. `extent` is the size of the
/// box around them in m.
pub(super) fn touch(shapes: &[&Collision], extent: &Vector3<f64>) -> Option<String> {
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for collision in shapes {
        let place = collision.pose.translation.vector;
        let axis = collision.pose.rotation * Vector3::z();
        match &collision.shape {
            Shape::Sphere(_) => points.push(place),
            Shape::Cylinder(_, radius) if axis.z.abs() > CENTRED.mul_add(-CENTRED, 1.0) => {
                points.extend([Vector3::x(), Vector3::y()].map(|way| place + way * *radius));
                points.extend([Vector3::x(), Vector3::y()].map(|way| place - way * *radius));
            }
            Shape::Capsule(half, _) | Shape::Cylinder(half, _) if axis.z.abs() < 0.5 => {
                points.extend([place + axis * *half, place - axis * *half]);
            }
            Shape::Capsule(half, _) | Shape::Cylinder(half, _) => {
                points.push(place - axis * (*half * axis.z.signum()))
            }
            // A box has flat faces.
            Shape::Box(_) => return None,
        }
    }
    let spread = |axis: usize| {
        let along = || points.iter().map(|point| point[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let narrow = [0, 1].map(|axis| spread(axis) < NARROW * extent[axis]);
    let kinds: Vec<&str> = shapes
        .iter()
        .map(|collision| match &collision.shape {
            Shape::Box(_) => "box",
            Shape::Capsule(..) => "capsule",
            Shape::Cylinder(..) => "cylinder",
            Shape::Sphere(_) => "sphere",
        })
        .collect();
    let what = match kinds.as_slice() {
        [kind] => format!("its lowest shape, a {kind},"),
        kinds => format!("its {} lowest shapes, round ones,", kinds.len()),
    };
    match narrow {
        [true, true] => Some(format!("{what} touches the ground in a point")),
        [true, false] | [false, true] => Some(format!("{what} touches the ground in a line")),
        [false, false] => None,
    }
}

/// A foot that is a wheel (W0419): round about the axis of its own joint.
pub(super) fn wheel(welded: &Welded, link: usize) -> Option<Diagnostic> {
    let moving = &welded.links[link];
    let axle = moving.hinge.axis?;
    let lowest = |collision: &Collision| {
        let block = around(collision);
        block.centre.z - block.half.z
    };
    let is_round = |collision: &Collision| {
        let place = collision.pose.translation.vector;
        let away = (place - axle.into_inner() * place.dot(&axle)).norm();
        match &collision.shape {
            Shape::Sphere(radius) => away < CENTRED * radius,
            Shape::Cylinder(_, radius) | Shape::Capsule(_, radius) => {
                let along = collision.pose.rotation * Vector3::z();
                along.cross(&axle).norm() < CENTRED && away < CENTRED * radius
            }
            Shape::Box(_) => false,
        }
    };
    let shape = moving.body.collisions.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b)));
    let named =
        [&moving.body.name, &moving.hinge.name].into_iter().any(|name| name.to_lowercase().contains("wheel"));
    if !(named || shape.is_some_and(is_round)) || axle.z.abs() > 0.5 {
        return None;
    }
    let message = format!(
        "the foot `{}` is a wheel about the axis of joint `{}`: wheels do not stand, and the box that \
         becomes its sole does",
        moving.body.name, moving.hinge.name
    );
    Some(Diagnostic::warning("W0419", message).help(
        "experiments need feet with flat soles: do not take results with this robot for those of the real \
         one, or name other feet \
         with --feet",
    ))
}
