//! States of the robots, and intermediate results of a step.

use super::constraint::Contacts;
use super::figures::Topology;
use super::lane::Lane;
use super::math::{Columns, Inertia, V3, zero3};
use super::scratch::Scratch;
use super::tree::{LONGEST, Matrix};

/// States of the robots, and the forces on them.
#[derive(Clone)]
pub struct Motion<L> {
    pub position: V3<L>,
    /// Quaternion w x y z.
    pub orientation: [L; 4],
    pub joints: Vec<L>,
    /// Of the base's origin, world axes.
    pub velocity: V3<L>,
    /// World axes.
    pub rate: V3<L>,
    pub joint_rates: Vec<L>,
    /// Accelerations of the last step.
    pub acceleration: Vec<L>,
    /// Accelerations with which the solver starts: those of the last step, extrapolated by their last change.
    /// That saves a sixth of the solver's steps at 500 Hz and a quarter at 2 kHz.
    pub warm: Vec<L>,
    /// Torques of the joints in N m.
    pub torque: Vec<L>,
    /// Force at the base's centre of mass in N, world axes.
    pub push: V3<L>,
    /// Force on each foot in the last step in N, world axes.
    pub foot_force: [V3<L>; 2],
    /// 1 where a shape of a body other than the feet was in the ground.
    pub body_touch: L,
    /// 1 where torques were applied since the last step.
    pub due: L,
    /// 1 until the first step.
    pub fresh: L,
    /// 1 where every number is finite and within physical bounds.
    pub sane: L,
}

impl<L: Lane> Motion<L> {
    /// At the origin, upright, at rest.
    pub fn at_rest(joints: usize) -> Self {
        let z = L::zero();
        Self {
            position: zero3(),
            orientation: [L::splat(1.0), z, z, z],
            joints: vec![z; joints],
            velocity: zero3(),
            rate: zero3(),
            joint_rates: vec![z; joints],
            acceleration: vec![z; 6 + joints],
            warm: vec![z; 6 + joints],
            torque: vec![z; joints],
            push: zero3(),
            foot_force: [zero3(); 2],
            body_touch: z,
            due: z,
            fresh: z,
            sane: z,
        }
    }
}

/// Intermediate results; valid within one step.
pub struct Work<L: Lane> {
    /// Of each body: axes, position relative to the base's origin, spatial velocity, acceleration without
    /// that of the joints, composite inertia, force.
    pub turn: Vec<Columns<L>>,
    pub place: Vec<V3<L>>,
    pub velocity: Vec<[V3<L>; 2]>,
    pub(super) bias: Vec<[V3<L>; 2]>,
    pub(super) inertia: Vec<Inertia<L>>,
    pub(super) force: Vec<[V3<L>; 2]>,
    /// Motion of each joint's body per joint rate.
    pub axes: Vec<[L; 6]>,
    pub mass: Matrix<L>,
    /// Unconstrained forces.
    pub smooth: Vec<L>,
    pub scratch: Vec<L>,
    pub contacts: Contacts<L>,
    pub solver: Scratch<L>,
}

impl<L: Lane> Work<L> {
    pub fn new(topology: &Topology) -> Self {
        let tree = &topology.tree;
        let (joints, z) = (tree.joints(), L::zero());
        let bodies = joints + 1;
        Self {
            turn: vec![[zero3(); 3]; bodies],
            place: vec![zero3(); bodies],
            velocity: vec![[zero3(); 2]; bodies],
            bias: vec![[zero3(); 2]; bodies],
            inertia: vec![Inertia::zero(); bodies],
            force: vec![[zero3(); 2]; bodies],
            axes: vec![[z; 6]; joints],
            mass: Matrix::zero(tree),
            smooth: vec![z; 6 + joints],
            scratch: vec![z; LONGEST * (6 + joints)],
            contacts: Contacts::default(),
            solver: Scratch::new(topology),
        }
    }
}
