//! Inputs of a label: a drawn state of the robot, and the parameters of its joints.

use nalgebra::Isometry3;

/// A state of the robot for which a label is computed.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// The base; only its orientation matters.
    pub base: Isometry3<f64>,
    /// Its yaw in rad: the heading.
    pub yaw: f64,
    /// Joint positions in rad.
    pub position: &'a [f64],
    /// Joint velocities minus the reference's, in rad/s.
    pub swing: &'a [f64],
}

/// Parameters of one joint.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Largest torque in N m.
    pub effort: f64,
    /// Proportional gain in N m/rad.
    pub stiffness: f64,
    /// Derivative gain in N m s/rad.
    pub damping: f64,
    /// Inertia of the rotor, reflected to the joint, in kg m^2.
    pub armature: f64,
    /// Position in the default pose in rad.
    pub default_position: f64,
}
