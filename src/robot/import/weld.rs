//! Welding: what hangs on a joint that is not selected becomes part of the body that carries it.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Vector3};
use regex::Regex;

use super::ImportError;
use super::tree::{Hinge, Tree, massless};
use crate::robot::{Body, Collision, Shape};

/// Shapes whose lowest points are within this distance of the lowest of all make the sole, in m.
const SOLE_DEPTH: f64 = 5e-3;

/// Which joints stay joints and which bodies are the feet.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The joints that stay; without it those between the base and the feet.
    pub joints: Option<Regex>,
    /// Names of the left and the right foot's body; without it the two lowest ends of the tree.
    pub feet: Option<[String; 2]>,
}

/// A tree of selected joints.
#[derive(Clone, Debug)]
pub struct Welded {
    /// The base with everything that is welded to it.
    pub base: Body,
    /// The moving bodies in the order of the file.
    pub links: Vec<Moving>,
    /// Left and right foot; the box is absent when the foot has no shape.
    pub feet: [(usize, Option<Block>); 2],
    /// Names of the joints that were welded, at their position zero.
    pub fixed: Vec<String>,
    /// What could not be taken over as it is, in sentences.
    pub notes: Vec<String>,
}

/// A moving body.
#[derive(Clone, Debug)]
pub struct Moving {
    /// The body with everything that is welded to it.
    pub body: Body,
    /// Index of its parent; `None` is the base.
    pub parent: Option<usize>,
    /// Pose of the joint in the parent's frame.
    pub origin: Isometry3<f64>,
    /// The joint.
    pub hinge: Hinge,
}

/// A box along the axes of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its centre in m.
    pub centre: Vector3<f64>,
    /// Its half extents in m.
    pub half: Vector3<f64>,
}

/// Where a body of the file went: `None` is the base.
type Owner = Option<usize>;

/// Welds what is not selected.
pub fn weld(tree: &Tree, selection: &Selection) -> Result<Welded, ImportError> {
    let kept = kept(tree, selection)?;
    let root = tree.parts.first().map_or("base", |part| part.body.name.as_str());
    let mut welded = Welded {
        base: massless(root),
        links: Vec::new(),
        feet: [(0, None), (0, None)],
        fixed: Vec::new(),
        notes: tree.notes.clone(),
    };
    // Of every body of the file: what it became part of, and its pose there.
    let mut places: Vec<(Owner, Isometry3<f64>)> = Vec::with_capacity(tree.parts.len());
    for (index, part) in tree.parts.iter().enumerate() {
        let (owner, carrier) = part.parent.map_or((None, Isometry3::identity()), |parent| places[parent]);
        let pose = carrier * part.pose;
        let place = match &part.hinge {
            Some(hinge) if kept[index] => {
                let origin = pose * Translation3::from(hinge.anchor);
                let body = massless(&part.body.name);
                welded.links.push(Moving { body, parent: owner, origin, hinge: hinge.clone() });
                (Some(welded.links.len() - 1), Translation3::from(-hinge.anchor).into())
            }
            hinge => {
                welded.fixed.extend(hinge.iter().map(|hinge| hinge.name.clone()));
                (owner, pose)
            }
        };
        let body = match place.0 {
            Some(link) => &mut welded.links[link].body,
            None => &mut welded.base,
        };
        join(body, &part.body, &place.1);
        places.push(place);
    }
    let owner = |name: &str| tree.parts.iter().position(|part| part.body.name == name).map(|index| places[index].0);
    let feet = match &selection.feet {
        Some(names) => named_feet(names, owner, &welded)?,
        None => lowest_ends(&mut welded)?,
    };
    welded.feet = feet.map(|link| (link, sole(&mut welded, link)));
    Ok(welded)
}

/// Of every body of the file whether its joint stays one.
fn kept(tree: &Tree, selection: &Selection) -> Result<Vec<bool>, ImportError> {
    let selected = |hinge: &Hinge| match &selection.joints {
        Some(pattern) => pattern.is_match(&hinge.name),
        None => hinge.other.is_none(),
    };
    let mut kept: Vec<bool> = tree.parts.iter().map(|part| part.hinge.as_ref().is_some_and(selected)).collect();
    if let (None, Some(feet)) = (&selection.joints, &selection.feet) {
        let mut needed = vec![false; tree.parts.len()];
        for foot in feet {
            let mut next = tree.parts.iter().position(|part| part.body.name == *foot);
            while let Some(index) = next {
                needed[index] = true;
                next = tree.parts[index].parent;
            }
        }
        kept.iter_mut().zip(needed).for_each(|(kept, needed)| *kept &= needed);
    }
    for hinge in tree.parts.iter().zip(&kept).filter(|(_, kept)| **kept).filter_map(|(part, _)| part.hinge.as_ref()) {
        if let Some(kind) = &hinge.other {
            return Err(ImportError::Joint { joint: hinge.name.clone(), kind: kind.clone() });
        }
    }
    match (&selection.joints, kept.contains(&true)) {
        (Some(pattern), false) => {
            Err(ImportError::Selector { pattern: pattern.to_string(), names: tree.joints().join(", ") })
        }
        _ => Ok(kept),
    }
}

/// Adds a body at a pose to another one (parallel axes).
fn join(whole: &mut Body, part: &Body, pose: &Isometry3<f64>) {
    for collision in &part.collisions {
        whole.collisions.push(Collision { shape: collision.shape.clone(), pose: pose * collision.pose });
    }
    if part.mass <= 0.0 {
        return;
    }
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    let (mass, com) = (whole.mass + part.mass, pose * part.com);
    let shifted = |inertia: Matrix3<f64>, mass: f64, arm: Vector3<f64>| {
        inertia + (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose()) * mass
    };
    let centre = Point3::from((whole.com.coords * whole.mass + com.coords * part.mass) / mass);
    let own = if whole.mass > 0.0 { shifted(whole.inertia, whole.mass, whole.com - centre) } else { Matrix3::zeros() };
    whole.inertia = own + shifted(turn * part.inertia * turn.transpose(), part.mass, com - centre);
    (whole.mass, whole.com) = (mass, centre);
}

fn named_feet(
    names: &[String; 2],
    owner: impl Fn(&str) -> Option<Owner>,
    welded: &Welded,
) -> Result<[usize; 2], ImportError> {
    let links = || welded.links.iter().map(|link| link.body.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut feet = [0; 2];
    for (foot, name) in feet.iter_mut().zip(names) {
        *foot = match owner(name) {
            Some(Some(link)) => link,
            Some(None) => {
                let reason = format!("`{name}` is welded to the base; the moving bodies are {}", links());
                return Err(ImportError::Feet { reason });
            }
            None => {
                let reason = format!("there is no body `{name}`; the moving bodies are {}", links());
                return Err(ImportError::Feet { reason });
            }
        };
    }
    Ok(feet)
}

/// The two ends of the tree that reach lowest with all joints at zero: left (larger y), right.
fn lowest_ends(welded: &mut Welded) -> Result<[usize; 2], ImportError> {
    let poses = poses(welded);
    let is_parent = |index: usize| welded.links.iter().any(|link| link.parent == Some(index));
    let mut ends: Vec<usize> = (0..welded.links.len()).filter(|index| !is_parent(*index)).collect();
    ends.sort_by(|a, b| poses[*a].translation.z.total_cmp(&poses[*b].translation.z));
    let &[a, b, ..] = ends.as_slice() else {
        let reason = "the selected joints have fewer than two ends; select both legs with --joints".to_owned();
        return Err(ImportError::Feet { reason });
    };
    let (left, right) = if poses[a].translation.y >= poses[b].translation.y { (a, b) } else { (b, a) };
    let names = [left, right].map(|index| welded.links[index].body.name.clone());
    welded.notes.push(format!(
        "the feet were not named: `{}` and `{}` are the ends of the tree that reach lowest (--feet names others)",
        names[0], names[1]
    ));
    Ok([left, right])
}

/// Poses of the moving bodies in the base's frame with all joints at zero.
fn poses(welded: &Welded) -> Vec<Isometry3<f64>> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(welded.links.len());
    for link in &welded.links {
        let carrier = link.parent.map_or(Isometry3::identity(), |parent| poses[parent]);
        poses.push(carrier * link.origin);
    }
    poses
}

/// The box around the lowest shapes of a foot; its other shapes are given up, because only the sole touches the ground.
fn sole(welded: &mut Welded, link: usize) -> Option<Block> {
    let body = &mut welded.links[link].body;
    let blocks: Vec<Block> = body.collisions.iter().map(around).collect();
    let low = |block: &Block| block.centre.z - block.half.z;
    let lowest = blocks.iter().map(low).min_by(f64::total_cmp)?;
    let (soles, others): (Vec<&Block>, Vec<&Block>) = blocks.iter().partition(|block| low(block) - lowest < SOLE_DEPTH);
    let corner = |sign: f64| {
        let corners = soles.iter().map(|block| block.centre + sign * block.half);
        corners.reduce(|a, b| if sign < 0.0 { a.inf(&b) } else { a.sup(&b) })
    };
    let (from, to) = (corner(-1.0)?, corner(1.0)?);
    if soles.len() > 1 || !others.is_empty() {
        welded.notes.push(format!(
            "`{}`: the sole is the box around its {} lowest shapes; {} others are left out",
            body.name,
            soles.len(),
            others.len()
        ));
    }
    body.collisions.clear();
    Some(Block { centre: 0.5 * (from + to), half: 0.5 * (to - from) })
}

/// The box around a shape, along the axes of its body.
pub(super) fn around(collision: &Collision) -> Block {
    let turn = collision.pose.rotation.to_rotation_matrix().into_inner().abs();
    let half = match &collision.shape {
        Shape::Box(half) => turn * half,
        Shape::Capsule(half, radius) => turn.column(2) * *half + Vector3::from_element(*radius),
        Shape::Sphere(radius) => Vector3::from_element(*radius),
    };
    Block { centre: collision.pose.translation.vector, half }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of point masses: mass, centre and inertia by direct sums.
    fn cluster(points: &[(f64, Vector3<f64>)]) -> Body {
        let mut body = massless("cluster");
        body.mass = points.iter().map(|(mass, _)| mass).sum();
        body.com = Point3::from(points.iter().map(|(mass, at)| at * *mass).sum::<Vector3<f64>>() / body.mass);
        for (mass, at) in points {
            let arm = at - body.com.coords;
            body.inertia += (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose()) * *mass;
        }
        body
    }

    #[test]
    fn two_welded_bodies_are_the_body_of_all_their_points() {
        let a = [(1.0, Vector3::new(0.1, 0.0, 0.2)), (2.0, Vector3::new(-0.1, 0.3, 0.0)), (0.5, Vector3::z())];
        let b = [(1.5, Vector3::new(0.0, 0.2, -0.2)), (0.7, Vector3::x()), (0.2, Vector3::new(0.3, 0.1, 0.4))];
        let pose = Isometry3::new(Vector3::new(0.4, -0.2, 0.7), Vector3::new(0.3, -0.5, 0.8));
        let mut whole = cluster(&a);
        join(&mut whole, &cluster(&b), &pose);
        let moved = b.map(|(mass, at)| (mass, (pose * Point3::from(at)).coords));
        let expected = cluster(&[a, moved].concat());
        assert!((whole.mass - expected.mass).abs() < 1e-12);
        assert!((whole.com - expected.com).norm() < 1e-12);
        assert!((whole.inertia - expected.inertia).norm() < 1e-12);
    }

    #[test]
    fn the_box_around_a_turned_box_holds_its_corners() {
        let half = Vector3::new(0.3, 0.1, 0.05);
        let pose = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.2, -0.4, 0.6));
        let block = around(&Collision { shape: Shape::Box(half), pose });
        let mut reach = Vector3::zeros();
        for corner in 0..8 {
            let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let at = pose * Point3::new(sign(0) * half.x, sign(1) * half.y, sign(2) * half.z);
            reach = reach.sup(&(at.coords - block.centre).abs());
        }
        assert!((reach - block.half).norm() < 1e-12);
    }
}
