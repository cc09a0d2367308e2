//! The robot model: a floating base and a tree of revolute joints, SI units, z up, x forward, y left.

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// A rigid-body robot with a floating base. `links[i].joint` carries `links[i]`; the order of `links` is the
/// joint order of every vector in the program (positions, velocities, torques, actions).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Its name, `robots/NAME.toml`.
    pub name: String,
    /// The floating base.
    pub base: Body,
    /// The moving links in joint order; parents come before their children.
    pub links: Vec<Link>,
    /// Left foot, right foot.
    pub feet: [Foot; 2],
    /// For each joint the index of its mirror image and the sign of the mirrored coordinate
    /// (reflection in the x-z plane).
    pub mirror: Vec<(usize, f64)>,
    /// Height of the base origin above flat ground in the default pose, soles flat, in m.
    pub standing_height: f64,
}

/// Mass properties and shapes of a rigid body, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// The body's name.
    pub name: String,
    /// Mass in kg.
    pub mass: f64,
    /// Centre of mass in the body frame, in m.
    pub com: Point3<f64>,
    /// Inertia about the centre of mass, axes of the body frame, in kg m^2.
    pub inertia: Matrix3<f64>,
    /// Collision shapes other than the soles, whose boxes are in [`Robot::feet`].
    pub collisions: Vec<Collision>,
}

/// A moving link and the joint that carries it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The rigid body.
    pub body: Body,
    /// Index of the parent link; `None` is the base.
    pub parent: Option<usize>,
    /// The joint between parent and link.
    pub joint: Joint,
}

/// A revolute joint with its drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// The joint's name.
    pub name: String,
    /// Pose of the joint (and of the link frame at position zero) in the parent's frame.
    pub origin: Isometry3<f64>,
    /// Axis of rotation in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Lower position limit in rad.
    pub lower: f64,
    /// Upper position limit in rad.
    pub upper: f64,
    /// Effort limit in N m.
    pub effort_limit: f64,
    /// Motor speed limit in rad/s; enforced only if a spec requests it.
    pub velocity_limit: f64,
    /// Viscous damping in N m s/rad.
    pub damping: f64,
    /// Coulomb friction in N m.
    pub friction: f64,
    /// Reflected rotor inertia in kg m^2.
    pub armature: f64,
    /// Proportional gain of the robot's own position control at 100 % stiffness, in N m/rad.
    pub stiffness_gain: f64,
    /// Derivative gain of the robot's own position control at 100 % stiffness, in N m s/rad.
    pub damping_gain: f64,
    /// Position in the default (knee-bent standing) pose, in rad.
    pub default_position: f64,
}

/// A foot: the link that may touch the ground, and its flat sole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Foot {
    /// Index of the foot's link.
    pub link: usize,
    /// Half extents of the sole's box in m.
    pub half_extents: Vector3<f64>,
    /// Centre of the box in the link frame, in m. The sole is the box's lower face.
    pub centre: Point3<f64>,
    /// Grip of the sole: factor on the ground's friction coefficient under this foot.
    #[serde(default = "whole", skip_serializing_if = "is_whole")]
    pub friction: f64,
}

/// A sole that leaves the ground's friction coefficient unchanged.
const fn whole() -> f64 {
    1.0
}

fn is_whole(factor: &f64) -> bool {
    *factor == whole()
}

/// A collision shape in its body's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    /// The shape.
    pub shape: Shape,
    /// Its pose in the body frame.
    pub pose: Isometry3<f64>,
}

/// The collision primitives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A box with these half extents in m.
    Box(Vector3<f64>),
    /// A capsule along z: half length of the cylinder part and radius in m.
    Capsule(f64, f64),
    /// A cylinder along z with flat ends: half length and radius in m.
    Cylinder(f64, f64),
    /// A sphere of this radius in m.
    Sphere(f64),
}

impl Body {
    /// Fixes a point mass in kg to the body, at a point of its frame in m.
    pub fn load(&mut self, mass: f64, point: Point3<f64>) {
        let total = self.mass + mass;
        if mass <= 0.0 || total <= 0.0 {
            return;
        }
        // Two masses about their common centre: the reduced mass at their distance.
        let arm = point - self.com;
        let square = Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        self.inertia += square * (self.mass * mass / total);
        self.com += arm * (mass / total);
        self.mass = total;
    }
}

impl Foot {
    /// Height of the sole in the link frame, in m (negative: below the link's origin).
    pub fn sole(&self) -> f64 {
        self.centre.z - self.half_extents.z
    }
}

impl Robot {
    /// Number of actuated joints.
    pub fn joints(&self) -> usize {
        self.links.len()
    }

    /// Total mass in kg.
    pub fn total_mass(&self) -> f64 {
        self.base.mass + self.links.iter().map(|link| link.body.mass).sum::<f64>()
    }

    /// The default pose, in rad, in joint order.
    pub fn default_pose(&self) -> Vec<f64> {
        self.links.iter().map(|link| link.joint.default_position).collect()
    }

    /// The effort limits, in N m, in joint order.
    pub fn effort_limits(&self) -> Vec<f64> {
        self.links.iter().map(|link| link.joint.effort_limit).collect()
    }
}
