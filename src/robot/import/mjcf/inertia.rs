//! The inertia at a joint in the file's initial pose, for what MuJoCo derives from it when compiling: springs
//! and dampers given by a time constant, and servos with a damping ratio.
//!
//! It is the inverse of MuJoCo's `dof_invweight0`, the diagonal of the inverse mass matrix, so all other
//! degrees of freedom are free to move.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Isometry3, Point3, Translation3, Vector3};

use super::super::intake::Intake;
use super::super::naming::some;
use super::super::tree::{Tree, Weight};
use super::drives::Ratio;
use crate::robot::kinematics::rotation_about;

/// Properties of a joint that depend on the masses.
#[derive(Clone, Debug, Default)]
pub(super) struct Open {
    /// Its position in rad, or in m, in the file's pose.
    pub reference: f64,
    /// Time constant in s and damping ratio of its spring.
    pub spring: Option<[f64; 2]>,
    /// Passive damping of its drives in N m s/rad.
    pub passive: f64,
    /// Its servos with a damping ratio.
    pub servos: Vec<Ratio>,
}

/// Sets the properties of joints that depend on the masses, by name; `floats` if the base is free to move.
pub(super) fn settle(tree: &mut Tree, floats: bool, open: &BTreeMap<String, Open>, intake: &mut Intake) {
    let wanted = |open: &Open| open.spring.is_some() || !open.servos.is_empty();
    let joints: Vec<(usize, &Open)> = tree
        .parts
        .iter()
        .enumerate()
        .filter_map(|(index, part)| {
            let hinge = part.hinge.as_ref().filter(|hinge| hinge.other.is_none())?;
            Some((index, open.get(&hinge.name).filter(|open| wanted(open))?))
        })
        .collect();
    if joints.is_empty() {
        return;
    }
    let inertias = inertias(tree, floats, open);
    let (mut dampers, mut servos, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
    for (index, open) in joints {
        let Some(hinge) = &mut tree.parts[index].hinge else { continue };
        let Some(inertia) = inertias.as_ref().and_then(|inertias| inertias.get(&index).copied()) else {
            unknown.push(hinge.name.clone());
            hinge.damping = hinge.damping.filter(|_| open.spring.is_none());
            hinge.damping_gain = hinge.damping_gain.filter(|_| open.servos.is_empty());
            continue;
        };
        if let Some([time, _]) = open.spring {
            // mjCModel::AutoSpringDamper: the spring's damping replaces the joint's own.
            hinge.damping = Some(2.0 * inertia / time + open.passive);
            dampers.push(hinge.name.clone());
        }
        if !open.servos.is_empty() {
            // mj_setConst: critical damping of a spring k on an inertia M is 2 sqrt(k M).
            let gain = |servo: &Ratio| 2.0 * servo.ratio * libm::sqrt((servo.stiffness * inertia).max(0.0));
            let known = hinge.damping_gain.unwrap_or(0.0);
            hinge.damping_gain = Some(known + open.servos.iter().map(gain).sum::<f64>());
            servos.push(hinge.name.clone());
        }
    }
    for (names, what, said) in [
        (
            dampers,
            "damping",
            "follows from `springdamper` and the inertia that the joint feels, as in MuJoCo",
        ),
        (
            servos,
            "damping gain",
            "follows from `dampratio` and the inertia that the joint feels, as in MuJoCo",
        ),
        (unknown, "damping", "depends on masses that are not known, and is to be filled in"),
    ] {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        if !names.is_empty() {
            intake.note(format!("the {what} of {} {said}", some(&names)));
        }
    }
}

/// Poses of all bodies in the base's frame, in the file's initial pose.
fn poses(tree: &Tree, open: &BTreeMap<String, Open>) -> Vec<Isometry3<f64>> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(tree.parts.len());
    for part in &tree.parts {
        let carrier = part.parent.map_or(Isometry3::identity(), |parent| poses[parent]);
        let moved = part.hinge.as_ref().and_then(|hinge| {
            let (reference, axis) = (open.get(&hinge.name)?.reference, hinge.axis?);
            let anchor = Translation3::from(hinge.anchor);
            Some(match &hinge.other {
                None => anchor * rotation_about(&axis, reference) * anchor.inverse(),
                Some(_) => Translation3::from(axis.into_inner() * reference).into(),
            })
        });
        poses.push(carrier * part.pose * moved.unwrap_or_default());
    }
    poses
}

/// A degree of freedom that moves everything on a joint: rotation about an axis through a point, or
/// translation.
struct Freedom {
    /// The body of the tree that it moves.
    body: usize,
    turn: Vector3<f64>,
    slide: Vector3<f64>,
    through: Point3<f64>,
    armature: f64,
}

impl Freedom {
    /// The velocity of a point.
    fn of(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.slide + self.turn.cross(&(point - self.through))
    }
}

/// The degrees of freedom of a tree, parents before children.
fn freedoms(tree: &Tree, poses: &[Isometry3<f64>], floats: bool) -> Vec<Freedom> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let none = Vector3::zeros();
    let freedom = |body: usize, turn, slide, armature| {
        let anchor = tree.parts[body].hinge.as_ref().map(|hinge| hinge.anchor).unwrap_or_default();
        Freedom { body, turn, slide, through: poses[body] * Point3::from(anchor), armature }
    };
    let mut all = Vec::new();
    if floats {
        all.extend(axes.map(|axis| freedom(0, axis, none, 0.0)));
        all.extend(axes.map(|axis| freedom(0, none, axis, 0.0)));
    }
    for (body, part) in tree.parts.iter().enumerate() {
        let Some(hinge) = &part.hinge else { continue };
        let armature = hinge.armature.unwrap_or(0.0);
        let axis = hinge.axis.map_or(none, |axis| poses[body] * axis.into_inner());
        match hinge.other.as_deref() {
            None => all.push(freedom(body, axis, none, armature)),
            Some(kind) if kind.contains("slide") => all.push(freedom(body, none, axis, armature)),
            Some(_) => all.extend(axes.map(|axis| freedom(body, poses[body] * axis, none, armature))),
        }
    }
    all
}

/// The inertia in kg m^2 at every revolute joint, by its body; `None` if a mass is unknown.
fn inertias(tree: &Tree, floats: bool, open: &BTreeMap<String, Open>) -> Option<BTreeMap<usize, f64>> {
    if tree.parts.iter().any(|part| part.weight == Weight::Unknown) {
        return None;
    }
    let poses = poses(tree, open);
    let freedoms = freedoms(tree, &poses, floats);
    let mut matrix = DMatrix::<f64>::zeros(freedoms.len(), freedoms.len());
    for (index, part) in tree.parts.iter().enumerate() {
        let mut above = vec![false; tree.parts.len()];
        std::iter::successors(Some(index), |body| tree.parts[*body].parent)
            .for_each(|body| above[body] = true);
        let moving: Vec<usize> = (0..freedoms.len()).filter(|place| above[freedoms[*place].body]).collect();
        let turn = poses[index].rotation.to_rotation_matrix().into_inner();
        let (tensor, com) = (turn * part.body.inertia * turn.transpose(), poses[index] * part.body.com);
        for row in &moving {
            for column in &moving {
                let (a, b) = (&freedoms[*row], &freedoms[*column]);
                matrix[(*row, *column)] +=
                    part.body.mass * a.of(&com).dot(&b.of(&com)) + a.turn.dot(&(tensor * b.turn));
            }
        }
    }
    for (place, freedom) in freedoms.iter().enumerate() {
        matrix[(place, place)] += freedom.armature;
    }
    let inverse = matrix.cholesky()?.inverse();
    let turning = |body: usize| tree.parts[body].hinge.as_ref().is_some_and(|hinge| hinge.other.is_none());
    let felt = freedoms.iter().enumerate().filter(|(_, freedom)| turning(freedom.body));
    Some(felt.map(|(place, freedom)| (freedom.body, 1.0 / inverse[(place, place)])).collect())
}
