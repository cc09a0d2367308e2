//! The body that is a robot's base: the first one with mass. A root such as `base_footprint` is only a frame.

use nalgebra::Isometry3;

use super::super::tree::{Part, Tree, Weight};

/// Share of the mass rigidly connected to the root below which a mass without shapes is nominal: simulators
/// reject massless bodies.
const NEGLIGIBLE: f64 = 1e-3;

/// The base of a tree.
#[derive(Clone, Debug)]
pub(in super::super) struct Root {
    /// Index of its body.
    pub body: usize,
    /// Its pose in the frame of the tree's root, joints at zero.
    pub pose: Isometry3<f64>,
    /// The bodies above it, from the root down.
    pub skipped: Vec<usize>,
}

/// The base of a tree with these remaining joints: the first body with mass that is fixed to the root, of
/// several the heaviest; the root if none has mass.
pub(in super::super) fn root(tree: &Tree, kept: &[bool]) -> Root {
    let mut rigid = vec![false; tree.parts.len()];
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(tree.parts.len());
    for (index, part) in tree.parts.iter().enumerate() {
        rigid[index] = part.parent.is_none_or(|parent| rigid[parent] && !kept[index]);
        poses.push(part.parent.map_or(Isometry3::identity(), |parent| poses[parent] * part.pose));
    }
    let together: f64 =
        tree.parts.iter().zip(&rigid).filter(|(_, rigid)| **rigid).map(|(part, _)| part.body.mass).sum();
    let is_frame = |part: &Part| {
        let negligible = part.body.mass <= NEGLIGIBLE * together && part.body.collisions.is_empty();
        part.weight != Weight::Unknown && (part.body.mass <= 0.0 || negligible)
    };
    let above = |index: usize| {
        let mut above: Vec<usize> =
            std::iter::successors(tree.parts[index].parent, |index| tree.parts[*index].parent).collect();
        above.reverse();
        above
    };
    let first = |index: &usize| {
        rigid[*index]
            && !is_frame(&tree.parts[*index])
            && above(*index).iter().all(|above| is_frame(&tree.parts[*above]))
    };
    let bodies = (0..tree.parts.len()).filter(first);
    // Of equally heavy ones the first.
    let heaviest = bodies.reduce(|best, next| if mass(tree, next) > mass(tree, best) { next } else { best });
    let body = heaviest.unwrap_or(0);
    Root { body, pose: if body == 0 { Isometry3::identity() } else { poses[body] }, skipped: above(body) }
}

fn mass(tree: &Tree, index: usize) -> f64 {
    tree.parts[index].body.mass
}

impl Root {
    /// The remark on the bodies above the base.
    pub fn remark(&self, tree: &Tree) -> Option<String> {
        let name = |index: &usize| format!("`{}`", tree.parts[*index].body.name);
        let names: Vec<String> = self.skipped.iter().map(name).collect();
        let have = match names.len() {
            0 => return None,
            1 => "has no mass and was skipped",
            _ => "have no mass and were skipped",
        };
        Some(format!(
            "{} {have}: the base is {}, the first body with mass",
            names.join(", "),
            name(&self.body)
        ))
    }
}
