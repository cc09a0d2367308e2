//! A robot as read from another format: a tree of bodies, SI units, in the order of the file.

use std::path::PathBuf;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::block::Block;
use crate::diag::Span;
use crate::robot::Body;
use crate::robot::kinematics::rotation_about;

/// Maximum number of bodies in a description.
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
    /// Remarks on what could not be imported unchanged.
    pub notes: Vec<String>,
    /// Rotation from the root's frame to the file's upright world; the identity if the file has none.
    pub upright: UnitQuaternion<f64>,
    /// Name of the key frame that the default positions come from.
    pub key: Option<String>,
    /// Rotation from the root's frame to the world in that key frame.
    pub stance: Option<UnitQuaternion<f64>>,
    /// The boxes that replace meshes.
    pub meshes: Vec<MeshBox>,
    /// Constraints between bodies or joints in addition to the tree.
    pub ties: Vec<Tie>,
}

/// A constraint of a file that a tree of joints cannot represent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tie {
    /// Two bodies are connected, which closes a loop. Their names, and the constraint with its name.
    Bodies {
        /// The two bodies.
        ends: [String; 2],
        /// For example `<connect> rod`.
        by: String,
    },
    /// A joint is coupled to another one.
    Joints {
        /// Name of the coupled joint.
        follower: String,
        /// Name of the joint that it is coupled to.
        leader: String,
    },
}

/// A box that replaces a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBox {
    /// Name of its body.
    pub body: String,
    /// The box in the mesh's own axes, in m.
    pub block: Block,
    /// The mesh's file.
    pub path: PathBuf,
    /// Scale factors from its points to m.
    pub scale: [f64; 3],
}

/// A body and its connection to its parent.
#[derive(Clone, Debug)]
pub struct Part {
    /// Mass, centre of mass, inertia about it (body axes) and shapes, in the body's frame.
    pub body: Body,
    /// Whether the file has its mass.
    pub weight: Weight,
    /// Index of the parent; `None` for the root.
    pub parent: Option<usize>,
    /// Pose of the body in its parent's frame, joint at zero.
    pub pose: Isometry3<f64>,
    /// The joint; `None` for the root and for a body fixed to its parent.
    pub hinge: Option<Hinge>,
    /// Place of its mass in the file, otherwise of the body.
    pub span: Option<Span>,
    /// Its shapes in the file.
    pub shapes: Shapes,
}

/// Numbers of shapes of a body in the file, imported or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shapes {
    /// Those that collide.
    pub colliding: usize,
    /// Those that do not, because their contact masks are zero.
    pub idle: usize,
}

/// What a file contains about the mass of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weight {
    /// Mass, centre of mass and inertia.
    #[default]
    Given,
    /// None, so the body is a frame without mass.
    Absent,
    /// It has a mass, but the value is unknown.
    Unknown,
}

/// A joint with the values in its file.
#[derive(Clone, Debug, Default)]
pub struct Hinge {
    /// Its name.
    pub name: String,
    /// Its kind if it is not revolute: `prismatic`, `ball`. Such a joint can only be welded.
    pub other: Option<String>,
    /// Point of the axis in the body's frame, in m.
    pub anchor: Vector3<f64>,
    /// Axis in the body's frame.
    pub axis: Option<Unit<Vector3<f64>>>,
    /// Lower limit in rad; in m for a sliding joint.
    pub lower: Option<f64>,
    /// Upper limit in rad; in m for a sliding joint.
    pub upper: Option<f64>,
    /// The ignored range in rad of a joint that the file declares continuous or unlimited.
    pub void_range: Option<[f64; 2]>,
    /// Limits that are zero in the file, which stands for unknown.
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
    /// Whether it has no drive although other joints of the file do.
    pub passive: bool,
    /// The rest position in rad of the spring of a joint without a drive; in m for a sliding joint.
    pub rest: Option<f64>,
    /// Its place.
    pub span: Option<Span>,
}

impl Tree {
    /// Names of the joints in the order of the file.
    pub fn joints(&self) -> Vec<&str> {
        self.parts.iter().filter_map(|part| part.hinge.as_ref()).map(|hinge| hinge.name.as_str()).collect()
    }
}

impl Tree {
    /// The tree with the welded joints at their positions in the key frame, where the file's pose is that of
    /// the whole robot; without a key frame they are at zero.
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
    /// Whether it is a sliding joint, with positions in m.
    pub(super) fn slides(&self) -> bool {
        self.other.as_ref().is_some_and(|kind| kind == "prismatic" || kind == "a slide joint")
    }

    /// Whether it turns about an axis as another joint does, and not by a motor of its own.
    pub(super) fn is_coupled(&self) -> bool {
        self.other.as_ref().is_some_and(|kind| kind.starts_with("driven by "))
    }

    /// The position at which it is welded, in rad (in m for a sliding joint): that of the key frame, else the
    /// rest position of its spring, else zero.
    pub(super) fn welded_at(&self) -> f64 {
        let moves = self.other.is_none() || self.slides();
        self.default_position.or(self.rest).filter(|position| moves && position.is_finite()).unwrap_or(0.0)
    }

    /// Whether it is welded outside its range.
    pub(super) fn is_welded_outside(&self) -> bool {
        let (lower, upper) = (self.lower.unwrap_or(f64::NEG_INFINITY), self.upper.unwrap_or(f64::INFINITY));
        lower > self.welded_at() + 1e-9 || upper < self.welded_at() - 1e-9
    }

    /// The body's motion due to the joint position, in the body's frame at zero.
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
