//! What the worlds of a group share (tree, axes, kinds of shapes), and the parameters in which they may
//! differ.

use super::lane::Lane;
use super::math::{Columns, V3};
use super::model::Kind;
use super::tree::Tree;

/// Impedance of constraints at zero depth and at [`WIDTH`] (MuJoCo's default `solimp`).
pub const IMPEDANCE: [f64; 2] = [0.9, 0.95];
/// Depth in m (or rad) at which the impedance reaches its full value.
pub const WIDTH: f64 = 0.001;

/// What all worlds of a group share.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// The tree in depth-first order.
    pub tree: Tree,
    /// The model's joint for each joint of the tree.
    pub order: Vec<usize>,
    /// Index of the coordinate axis of its link's frame about which each joint rotates.
    pub axis: Vec<usize>,
    /// Whether a joint's frame has the orientation of its parent's.
    pub plain: Vec<bool>,
    /// The shapes, by body.
    pub shapes: Vec<ShapeOf>,
}

/// The part of a shape that worlds share.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeOf {
    /// Its body.
    pub body: usize,
    /// Its kind; the size is a parameter.
    pub kind: ShapeKind,
    /// Whether it has the orientation of its body.
    pub plain: bool,
    /// The foot that it belongs to.
    pub foot: Option<usize>,
}

/// Kinds of shapes without their sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    Box,
    Capsule,
    Cylinder,
    Sphere,
}

impl ShapeKind {
    pub(super) fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Box(_) => Self::Box,
            Kind::Capsule(..) => Self::Capsule,
            Kind::Cylinder(..) => Self::Cylinder,
            Kind::Sphere(_) => Self::Sphere,
        }
    }
}

/// The parameters of worlds, one lane each.
#[derive(Clone, Debug)]
pub struct Figures<L> {
    /// Joints: position and orientation in the parent's frame.
    pub place: Vec<V3<L>>,
    pub turn: Vec<Columns<L>>,
    pub armature: Vec<L>,
    pub damping: Vec<L>,
    pub friction: Vec<L>,
    /// 1/R of the row of joint friction.
    pub friction_d: Vec<L>,
    /// MuJoCo's `dof_invweight0`.
    pub joint_weight: Vec<L>,
    pub lower: Vec<L>,
    pub upper: Vec<L>,
    pub effort: Vec<L>,
    /// Bodies.
    pub com: Vec<V3<L>>,
    pub tensor: Vec<[L; 6]>,
    pub mass: Vec<L>,
    /// MuJoCo's `body_invweight0`, translation.
    pub weight: Vec<L>,
    /// Bounding sphere of the body's shapes: centre and radius.
    pub around: Vec<[L; 4]>,
    /// Shapes.
    pub shape_place: Vec<V3<L>>,
    pub shape_turn: Vec<Columns<L>>,
    pub shape_size: Vec<V3<L>>,
    pub shape_friction: Vec<L>,
    /// Parameters per world.
    pub world: [World<L>; 1],
}

/// Parameters per world.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct World<L> {
    pub step: L,
    pub gravity: L,
    /// Damping 2 / (d t) and stiffness 1 / (d t)^2 of the reference acceleration of contacts.
    pub contact_b: L,
    pub contact_k: L,
    /// The same for joint limits and joint friction.
    pub row_b: L,
    pub row_k: L,
    /// Square of the gradient's norm below which the solver stops.
    pub small_gradient: L,
    /// Newton decrement below which a step is the solver's last.
    pub small_decrement: L,
    /// 1 where any joint is damped.
    pub damped: L,
}

impl<L> World<L> {
    const NUMBERS: usize = 9;

    fn numbers(&self) -> &[L] {
        // SAFETY: `repr(C)` with that many fields of one type.
        unsafe { std::slice::from_raw_parts(std::ptr::from_ref(self).cast(), Self::NUMBERS) }
    }

    fn numbers_mut(&mut self) -> &mut [L] {
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(std::ptr::from_mut(self).cast(), Self::NUMBERS) }
    }
}

macro_rules! all_parts {
    ($figures:expr, $flat:ident, $numbers:ident, $($borrow:tt)+) => {
        [
            $figures.place.$flat(),
            $figures.turn.$flat().$flat(),
            $($borrow)+ $figures.armature,
            $($borrow)+ $figures.damping,
            $($borrow)+ $figures.friction,
            $($borrow)+ $figures.friction_d,
            $($borrow)+ $figures.joint_weight,
            $($borrow)+ $figures.lower,
            $($borrow)+ $figures.upper,
            $($borrow)+ $figures.effort,
            $figures.com.$flat(),
            $figures.tensor.$flat(),
            $($borrow)+ $figures.mass,
            $($borrow)+ $figures.weight,
            $figures.around.$flat(),
            $figures.shape_place.$flat(),
            $figures.shape_turn.$flat().$flat(),
            $figures.shape_size.$flat(),
            $($borrow)+ $figures.shape_friction,
            $figures.world[0].$numbers(),
        ]
    };
}

impl<L: Lane> Figures<L> {
    /// Storage for the worlds of a topology, all parameters zero.
    pub fn room(topology: &Topology) -> Self {
        let (joints, shapes) = (topology.tree.joints(), topology.shapes.len());
        let (z, bodies) = (L::zero(), joints + 1);
        Self {
            place: vec![[z; 3]; joints],
            turn: vec![[[z; 3]; 3]; joints],
            armature: vec![z; joints],
            damping: vec![z; joints],
            friction: vec![z; joints],
            friction_d: vec![z; joints],
            joint_weight: vec![z; joints],
            lower: vec![z; joints],
            upper: vec![z; joints],
            effort: vec![z; joints],
            com: vec![[z; 3]; bodies],
            tensor: vec![[z; 6]; bodies],
            mass: vec![z; bodies],
            weight: vec![z; bodies],
            around: vec![[z; 4]; bodies],
            shape_place: vec![[z; 3]; shapes],
            shape_turn: vec![[[z; 3]; 3]; shapes],
            shape_size: vec![[z; 3]; shapes],
            shape_friction: vec![z; shapes],
            world: [World {
                step: z,
                gravity: z,
                contact_b: z,
                contact_k: z,
                row_b: z,
                row_k: z,
                small_gradient: z,
                small_decrement: z,
                damped: z,
            }],
        }
    }

    fn parts(&self) -> [&[L]; 20] {
        all_parts!(self, as_flattened, numbers, &)
    }

    fn parts_mut(&mut self) -> [&mut [L]; 20] {
        all_parts!(self, as_flattened_mut, numbers_mut, &mut)
    }

    /// Writes the parameters of one world into a lane.
    pub fn load(&mut self, lane: usize, from: &Figures<f64>) {
        for (own, from) in self.parts_mut().into_iter().zip(from.parts()) {
            let own = L::numbers_mut(own);
            for (index, figure) in from.iter().enumerate() {
                own[index * L::LANES + lane] = *figure;
            }
        }
    }
}
