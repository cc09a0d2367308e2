//! A robot as another program's file has it: a tree of bodies, SI units, in the order of the file.

use std::path::PathBuf;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::block::Block;
use crate::diag::Span;
use crate::robot::Body;
use crate::robot::kinematics::rotation_about;

/// Most bodies that a description may have.
pub(super) const MOST_BODIES: usize = 500;

/// The bodies of a file, parents before children; the first is the root.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// The robot's name in the file.
    pub name: String,
    /// `URDF` or `MJCF`.
    pub format: &'static str,
    /// The bodies.
    pub parts: Vec<Part>,
    /// What could not be taken over as it is, in sentences.
    pub notes: Vec<String>,
    /// The upright world in which the file puts the robot, from the root's frame; the identity where it says
    /// nothing.
    pub upright: UnitQuaternion<f64>,
    /// Name of the key frame of which the default positions are.
    pub key: Option<String>,
    /// World from the root's frame in the key frame of which the default positions are.
    pub stance: Option<UnitQuaternion<f64>>,
    /// The boxes that stand for meshes.
    pub meshes: Vec<MeshBox>,
    /// What ties bodies or joints together beside the tree.
    pub ties: Vec<Tie>,
}

/// A constraint of a file that a tree of joints does not have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tie {
    /// Two bodies meet: a loop is closed. Their names, and the constraint with its own name.
    Bodies {
        /// The two bodies.
        ends: [String; 2],
        /// For example `<connect> rod`.
        by: String,
    },
    /// A joint follows another one.
    Joints {
        /// Name of the joint that follows.
        follower: String,
        /// Name of the joint that it follows.
        leader: String,
    },
}

/// A box that stands for a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBox {
    /// Name of the body that has it.
    pub body: String,
    /// The box in the mesh's own axes, in m.
    pub block: Block,
    /// The mesh's file.
    pub path: PathBuf,
    /// Factors from its points to m.
    pub scale: [f64; 3],
}

/// A body and how it hangs on its parent.
#[derive(Clone, Debug)]
pub struct Part {
    /// Mass, centre of mass, inertia about it (body axes) and shapes, in the body's frame.
    pub body: Body,
    /// Whether the file holds its mass.
    pub weight: Weight,
    /// Index of the parent; `None` for the root.
    pub parent: Option<usize>,
    /// Pose of the body in its parent's frame, joint at zero.
    pub pose: Isometry3<f64>,
    /// The joint; `None` for a body that is fixed to its parent, and for the root.
    pub hinge: Option<Hinge>,
    /// Where the file gives its mass, or else the body.
    pub span: Option<Span>,
    /// The shapes that the file gives it.
    pub shapes: Shapes,
}

/// How many shapes a file gives a body, whether they are imported or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shapes {
    /// Those that collide.
    pub colliding: usize,
    /// Those that touch nothing, because their contact masks are zero.
    pub idle: usize,
}

/// What a file says of the mass of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weight {
    /// Mass, centre of mass and inertia.
    #[default]
    Given,
    /// Nothing, so the body is a frame without mass.
    Absent,
    /// That it has a mass which cannot be told without inventing it.
    Unknown,
}

/// A joint with the figures that its file holds.
#[derive(Clone, Debug, Default)]
pub struct Hinge {
    /// Its name.
    pub name: String,
    /// What it is when it is not revolute: `prismatic`, `ball`. Such a joint can only be welded.
    pub other: Option<String>,
    /// Point of the axis in the body's frame, in m.
    pub anchor: Vector3<f64>,
    /// Axis in the body's frame.
    pub axis: Option<Unit<Vector3<f64>>>,
    /// Lower limit in rad; of a joint that slides in m.
    pub lower: Option<f64>,
    /// Upper limit in rad; of a joint that slides in m.
    pub upper: Option<f64>,
    /// The range in rad that the file gives a joint which it calls continuous or not limited: it does not
    /// count.
    pub void_range: Option<[f64; 2]>,
    /// The limits that the file gives as zero, which stands for one that is not known.
    pub zeros: Vec<&'static str>,
    /// Effort limit in N m.
    pub effort_limit: Option<f64>,
    /// Speed limit in rad/s.
    pub velocity_limit: Option<f64>,
    /// Viscous damping in N m s/rad.
    pub damping: Option<f64>,
    /// Coulomb friction in N m.
    pub friction: Option<f64>,
    /// Reflected rotor inertia in kg m^2.
    pub armature: Option<f64>,
    /// Proportional gain of position control in N m/rad.
    pub stiffness_gain: Option<f64>,
    /// Derivative gain of position control in N m s/rad.
    pub damping_gain: Option<f64>,
    /// Default position in rad.
    pub default_position: Option<f64>,
    /// Whether the file drives other joints and not this one.
    pub passive: bool,
    /// The position in rad at which the spring of a joint that nothing drives is at rest; of one that slides
    /// in m.
    pub rest: Option<f64>,
    /// Where it stands.
    pub span: Option<Span>,
}

impl Tree {
    /// Names of the joints in the order of the file.
    pub fn joints(&self) -> Vec<&str> {
        self.parts.iter().filter_map(|part| part.hinge.as_ref()).map(|hinge| hinge.name.as_str()).collect()
    }
}

impl Tree {
    /// The tree with the joints that are not kept turned to their positions in the key frame, in which the
    /// file's pose is that of the whole robot; without a key frame they are at zero.
    pub(super) fn posed(&self, kept: &[bool]) -> Self {
        let mut tree = self.clone();
        for (part, kept) in tree.parts.iter_mut().zip(kept) {
            if let Some(hinge) = part.hinge.as_ref().filter(|_| !kept) {
                part.pose *= hinge.motion(hinge.welded_at());
            }
        }
        tree
    }
}

impl Hinge {
    /// Whether it slides: its positions are in m.
    pub(super) fn slides(&self) -> bool {
        self.other.as_ref().is_some_and(|kind| kind.contains("prismatic") || kind.contains("slide"))
    }

    /// The position in rad, of a joint that slides in m, at which it is welded: that of the key frame, or
    /// where its spring is at rest, or zero.
    pub(super) fn welded_at(&self) -> f64 {
        let moves = self.other.is_none() || self.slides();
        self.default_position.or(self.rest).filter(|position| moves && position.is_finite()).unwrap_or(0.0)
    }

    /// Whether the position at which it is welded is none that it can have.
    pub(super) fn is_welded_outside(&self) -> bool {
        let (lower, upper) = (self.lower.unwrap_or(f64::NEG_INFINITY), self.upper.unwrap_or(f64::INFINITY));
        lower > self.welded_at() + 1e-9 || upper < self.welded_at() - 1e-9
    }

    /// What the joint does at a position to the body, in the body's frame at zero.
    fn motion(&self, position: f64) -> Isometry3<f64> {
        let Some(axis) = self.axis.filter(|_| position != 0.0) else { return Isometry3::identity() };
        if self.slides() {
            return Translation3::from(axis.into_inner() * position).into();
        }
        let anchor = Translation3::from(self.anchor);
        anchor * rotation_about(&axis, position) * anchor.inverse()
    }
}

/// A body without mass and shapes.
pub(super) fn massless(name: &str) -> Body {
    Body {
        name: name.to_owned(),
        mass: 0.0,
        com: Point3::origin(),
        inertia: Matrix3::zeros(),
        collisions: Vec::new(),
    }
}
