//! Temporary values of the solver.

use super::figures::Topology;
use super::lane::Lane;
use super::math::{V3, zero3};
use super::stiffness::Stiffness;
use super::tree::Matrix;

/// Values that the solver computes in a step.
pub struct Scratch<L> {
    pub acceleration: Vec<L>,
    /// Contacts: force on each foot, and 1 where a shape of another body is in the ground.
    pub foot_force: [V3<L>; 2],
    pub body_touch: L,
    /// M times the acceleration, and the gradient.
    pub(super) inertial: Vec<L>,
    pub(super) gradient: Vec<L>,
    pub(super) search: Vec<L>,
    pub(super) inertial_search: Vec<L>,
    /// Forces including those of the constraints.
    pub total: Vec<L>,
    pub hessian: Matrix<L>,
    /// Joints: gap of the friction row, the limit's direction, 1/R and reference, second derivative of both
    /// rows.
    pub(super) friction_gap: Vec<L>,
    pub(super) limit_sign: Vec<L>,
    pub(super) limit_d: Vec<L>,
    pub(super) limit_reference: Vec<L>,
    pub(super) diagonal: Vec<L>,
    /// Bodies: wrench of the contacts, spatial stiffness, and the body whose stiffness represents this one's
    /// subtree.
    pub(super) wrench: Vec<[V3<L>; 2]>,
    pub(super) stiffness: Vec<Stiffness<L>>,
    pub(super) source: Vec<usize>,
    pub(super) motion: Vec<[V3<L>; 2]>,
    /// Whether any lane is beyond a limit.
    pub(super) limited: bool,
    /// Whether a body or one of its descendants touches the ground.
    pub(super) carries: Vec<bool>,
}

impl<L: Lane> Scratch<L> {
    pub fn new(topology: &Topology) -> Self {
        let (joints, z) = (topology.tree.joints(), L::zero());
        let (bodies, size) = (joints + 1, 6 + joints);
        Self {
            acceleration: vec![z; size],
            foot_force: [zero3(); 2],
            body_touch: z,
            inertial: vec![z; size],
            gradient: vec![z; size],
            search: vec![z; size],
            inertial_search: vec![z; size],
            total: vec![z; size],
            hessian: Matrix::zero(&topology.tree),
            friction_gap: vec![z; joints],
            limit_sign: vec![z; joints],
            limit_d: vec![z; joints],
            limit_reference: vec![z; joints],
            diagonal: vec![z; joints],
            wrench: vec![[zero3(); 2]; bodies],
            stiffness: vec![Stiffness::zero(); bodies],
            source: vec![0; bodies],
            motion: vec![[zero3(); 2]; bodies],
            limited: false,
            carries: vec![false; bodies],
        }
    }
}
