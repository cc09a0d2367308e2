//! What a kind may see of the world after a control step.

use super::motion::Frame;

/// The world after a control step, as plain numbers. Frames: world has x forward at the start, y left,
/// z up; heading is the world frame turned about z by the base's yaw. Joint vectors are in joint order.
/// Feet are left, right.
#[derive(Clone, Copy, Debug)]
pub struct Signals<'a> {
    /// Duration of the control step in s.
    pub step: f64,
    /// Time since the start of the episode in s.
    pub time: f64,
    /// Phase of the motion in `[0, 1)`, after the step.
    pub phase: f64,
    /// Change of the (unwrapped) phase over the step.
    pub phase_step: f64,
    /// Reference motion at `phase`.
    pub reference: &'a Frame,
    /// Commanded forward speed in m/s.
    pub command_speed: f64,
    /// Position of the base origin in the world in m.
    pub base_position: [f64; 3],
    /// Height of the base origin above the ground below it in m.
    pub base_height: f64,
    /// Orientation of the base, unit quaternion w x y z, world from base.
    pub base_orientation: [f64; 4],
    /// Velocity of the base origin in the heading frame in m/s.
    pub base_velocity: [f64; 3],
    /// Angular velocity of the base in the heading frame in rad/s.
    pub base_rate: [f64; 3],
    /// Joint positions in rad.
    pub position: &'a [f64],
    /// Joint velocities in rad/s (true, not filtered).
    pub velocity: &'a [f64],
    /// Joint velocities at the end of the previous control step in rad/s.
    pub previous_velocity: &'a [f64],
    /// Commanded joint torques of this step in N m (mean over the step's physics steps).
    pub torque: &'a [f64],
    /// Commanded joint torques of the previous step in N m.
    pub previous_torque: &'a [f64],
    /// Force of the ground on each foot in N, world frame, mean over the control step.
    pub foot_force: [[f64; 3]; 2],
    /// The same for the previous control step.
    pub previous_foot_force: [[f64; 3]; 2],
    /// Whether each foot carries more than 10 N (step mean of the vertical force).
    pub foot_contact: [bool; 2],
    /// Whether anything but the feet touched the ground during the step.
    pub body_contact: bool,
}
