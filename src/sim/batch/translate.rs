//! Converts a robot and its terrain into the plain numbers of the dynamics.

use nalgebra::{Isometry3, Matrix3};

use super::super::error::EngineError;
use super::super::scene::{EngineSettings, Terrain};
use super::super::terrain::Piece;
use super::model;
use super::refused;
use crate::robot::model::Body;
use crate::robot::{Foot, GRAVITY, Robot, Shape};

/// Default time constant of contacts in s, as in the MuJoCo engine.
const CONTACT_TIME: f64 = 0.02;
/// Depth of a height field's solid below its lowest point, in m, as in the MuJoCo engine.
const FIELD_BASE: f64 = 0.1;
/// The smallest mass in kg and moment of inertia in kg m^2.
const SMALLEST: f64 = 1e-15;

/// The robot on ground with this friction coefficient.
pub(super) fn model(robot: &Robot, friction: f64) -> Result<model::Model, EngineError> {
    if !friction.is_finite() {
        return Err(refused("the friction of the ground is not a number"));
    }
    let mut bodies = vec![body(&robot.base, shapes(&robot.base, friction))?];
    let mut joints = Vec::with_capacity(robot.joints());
    for (index, link) in robot.links.iter().enumerate() {
        // A foot's link has one shape, the box of its sole.
        let shapes = match robot.feet.iter().position(|foot| foot.link == index) {
            Some(side) => vec![sole(side, &robot.feet[side], friction)],
            None => shapes(&link.body, friction),
        };
        bodies.push(body(&link.body, shapes)?);
        let joint = &link.joint;
        let figures =
            [joint.damping, joint.friction, joint.armature, joint.effort_limit, joint.lower, joint.upper];
        if !figures.iter().all(|figure| figure.is_finite()) {
            return Err(refused(format!("a figure of joint `{}` is not a number", joint.name)));
        }
        joints.push(model::Joint {
            parent: link.parent.map_or(0, |parent| parent + 1),
            place: joint.origin.translation.vector.into(),
            turn: rows(&joint.origin),
            axis: joint.axis.into_inner().into(),
            limits: [joint.lower, joint.upper],
            effort: joint.effort_limit,
            damping: joint.damping,
            friction: joint.friction,
            armature: joint.armature,
        });
    }
    Ok(model::Model { bodies, joints })
}

fn rows(pose: &Isometry3<f64>) -> model::Rows {
    let turn = pose.rotation.to_rotation_matrix();
    std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)]))
}

/// A body, if its mass properties are physically possible.
fn body(body: &Body, shapes: Vec<model::Shape>) -> Result<model::Body, EngineError> {
    let i = &body.inertia;
    if !i.iter().chain(body.com.iter()).all(|figure| figure.is_finite()) {
        return Err(refused(format!("a figure of body `{}` is not a number", body.name)));
    }
    let mut moments: Vec<f64> = Matrix3::symmetric_eigenvalues(i).iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    // Comparisons with NaN are false.
    let is_possible = body.mass >= SMALLEST
        && moments[0] >= SMALLEST
        // A thin plate, the limiting case, may violate it by rounding.
        && (moments[0] + moments[1]) * (1.0 + 1e-9) >= moments[2];
    if !is_possible {
        return Err(refused(format!(
            "no solid has the mass and the moments of inertia of body `{}`",
            body.name
        )));
    }
    Ok(model::Body {
        mass: body.mass,
        com: body.com.coords.into(),
        inertia: [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]],
        shapes,
    })
}

fn shapes(body: &Body, friction: f64) -> Vec<model::Shape> {
    let shape = |collision: &crate::robot::Collision| model::Shape {
        kind: match collision.shape {
            Shape::Box(half) => model::Kind::Box(half.into()),
            Shape::Capsule(half, radius) => model::Kind::Capsule(half, radius),
            Shape::Cylinder(half, radius) => model::Kind::Cylinder(half, radius),
            Shape::Sphere(radius) => model::Kind::Sphere(radius),
        },
        place: collision.pose.translation.vector.into(),
        turn: rows(&collision.pose),
        friction,
        foot: None,
    };
    body.collisions.iter().map(shape).collect()
}

fn sole(side: usize, foot: &Foot, friction: f64) -> model::Shape {
    model::Shape {
        kind: model::Kind::Box(foot.half_extents.into()),
        place: foot.centre.coords.into(),
        turn: model::IDENTITY,
        friction: foot.friction * friction,
        foot: Some(side),
    }
}

pub(super) fn settings(settings: &EngineSettings) -> model::Settings {
    let contact_time = settings.contact_time.unwrap_or(CONTACT_TIME);
    model::Settings { step: settings.step, gravity: GRAVITY, contact_time }
}

pub(super) fn ground(terrain: &Terrain) -> model::Ground {
    let mut ground = model::Ground::default();
    for piece in terrain.pieces() {
        match piece {
            Piece::Plane { point, normal } => ground.planes.push(model::Plane { point, normal }),
            Piece::Box { centre, half } => ground.boxes.push(model::Block { centre, half }),
            Piece::Field { cell, counts, heights } => {
                let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
                ground.field = Some(model::Field::new(cell, counts, heights.to_vec(), lowest - FIELD_BASE));
            }
        }
    }
    ground
}
