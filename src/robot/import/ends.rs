//! Which two ends of a tree are the feet: those that reach lowest, whatever the orientation of the tree's
//! frame.

use nalgebra::{Isometry3, Point3, Vector3};

use super::tree::Tree;
use super::welded::Welded;

/// Minimum cosine of the angle to the legs of an up direction.
const UPWARDS: f64 = 0.3;
/// Minimum length of the sum of both legs' vectors, relative to the sum of their lengths.
const TOGETHER: f64 = 0.5;
/// Maximum difference of the feet's heights, relative to the length of the legs.
const LEVEL: f64 = 0.1;

/// The joints of a tree with all positions at zero.
#[derive(Clone, Debug, Default)]
pub(super) struct Joints {
    /// Points on the axes in the root frame, in m.
    anchors: Vec<Vector3<f64>>,
    /// The parent joint of each; `None` on the base.
    parents: Vec<Option<usize>>,
    /// Indices of the joints' bodies.
    bodies: Vec<usize>,
}

/// The result of the search for the feet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Feet {
    /// Bodies of two ends.
    Pair([usize; 2]),
    /// Fewer than two ends.
    Fewer(Vec<usize>),
    /// Several pairs of ends, or none, reach lowest along their own legs.
    Unclear,
}

impl Joints {
    /// The joints of a file that remain joints.
    pub fn of_tree(tree: &Tree, kept: &[bool]) -> Self {
        let mut joints = Self::default();
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(kept.len());
        let mut carriers: Vec<Option<usize>> = Vec::with_capacity(kept.len());
        for (index, part) in tree.parts.iter().enumerate() {
            let pose = part.parent.map_or(Isometry3::identity(), |parent| poses[parent]) * part.pose;
            let mut carrier = part.parent.and_then(|parent| carriers[parent]);
            if kept[index] {
                let anchor = part.hinge.as_ref().map_or(Vector3::zeros(), |hinge| hinge.anchor);
                joints.push((pose * Point3::from(anchor)).coords, carrier, index);
                carrier = Some(joints.anchors.len() - 1);
            }
            poses.push(pose);
            carriers.push(carrier);
        }
        joints
    }

    /// The joints of a welded tree.
    pub fn of_welded(welded: &Welded) -> Self {
        let mut joints = Self::default();
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(welded.links.len());
        for (index, link) in welded.links.iter().enumerate() {
            let pose = link.parent.map_or(Isometry3::identity(), |parent| poses[parent]) * link.origin;
            joints.push(pose.translation.vector, link.parent, index);
            poses.push(pose);
        }
        joints
    }

    fn push(&mut self, anchor: Vector3<f64>, parent: Option<usize>, body: usize) {
        self.anchors.push(anchor);
        self.parents.push(parent);
        self.bodies.push(body);
    }

    /// The feet, given the file's up direction.
    pub fn feet(&self, up: &Vector3<f64>) -> Feet {
        let is_parent = |index: usize| self.parents.contains(&Some(index));
        let mut ends: Vec<usize> = (0..self.anchors.len()).filter(|index| !is_parent(*index)).collect();
        let height = |end: &usize| self.anchors[*end].dot(up);
        ends.sort_by(|a, b| height(a).total_cmp(&height(b)));
        let bodies = |pair: [usize; 2]| Feet::Pair(pair.map(|end| self.bodies[end]));
        match *ends.as_slice() {
            [a, b, ref others @ ..] => {
                let legs = self.upwards([a, b]);
                if others.is_empty() || legs.norm() < 1e-3 || legs.dot(up) > UPWARDS * legs.norm() {
                    return bodies([a, b]);
                }
                let pairs = (0..ends.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
                let pairs = pairs
                    .map(|pair| pair.map(|index| ends[index]))
                    .filter(|pair| self.reach_lowest(*pair, &ends));
                match *pairs.collect::<Vec<_>>().as_slice() {
                    [pair] => bodies(pair),
                    _ => Feet::Unclear,
                }
            }
            _ => Feet::Fewer(ends.into_iter().map(|end| self.bodies[end]).collect()),
        }
    }

    /// The joints from an end up to the base.
    fn chain(&self, end: usize) -> Vec<usize> {
        std::iter::successors(Some(end), |joint| self.parents[*joint]).collect()
    }

    /// The vectors from each end to the first joint of its limb, which carries only that end.
    fn limbs(&self, pair: [usize; 2]) -> [Vector3<f64>; 2] {
        let chains = pair.map(|end| self.chain(end));
        [0, 1].map(|side| {
            let own = chains[side].iter().rfind(|joint| !chains[1 - side].contains(joint)).copied();
            self.anchors[own.unwrap_or(pair[side])] - self.anchors[pair[side]]
        })
    }

    fn upwards(&self, pair: [usize; 2]) -> Vector3<f64> {
        let [first, second] = self.limbs(pair);
        first + second
    }

    /// Whether two ends are side by side and lower than all others, taking their limbs as the up direction.
    fn reach_lowest(&self, pair: [usize; 2], ends: &[usize]) -> bool {
        let [first, second] = self.limbs(pair);
        let (legs, length) = (first + second, first.norm() + second.norm());
        if length < 1e-3 || legs.norm() < TOGETHER * length {
            return false;
        }
        let up = legs.normalize();
        let height = |end: usize| self.anchors[end].dot(&up);
        let others = ends.iter().filter(|end| !pair.contains(end));
        let highest = pair.map(height).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let like = self.chain(pair[0]).len() == self.chain(pair[1]).len();
        like && (height(pair[0]) - height(pair[1])).abs() < LEVEL * length
            && others.into_iter().all(|other| height(*other) > highest)
    }
}
