//! Signals: the state of the world after a control step, as kinds can read it.

use super::motion::Frame;

/// The world after a control step, as plain numbers. Frames: world has x forward at the start, y left, z up;
/// heading is the world frame rotated about z by the base's yaw. Joint vectors are in joint order. Feet are
/// left, right.
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
    /// Standing height of this episode's robot divided by the nominal robot's; 1 unless its legs are scaled.
    pub stature: f64,
    /// Orientation of the base, unit quaternion w x y z, world from base.
    pub base_orientation: [f64; 4],
    /// Velocity of the base origin in the heading frame in m/s.
    pub base_velocity: [f64; 3],
    /// The velocity averaged over about a step: an exponential average with a time constant of half a cycle
    /// of the motion.
    pub mean_velocity: [f64; 3],
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
    /// Whether anything other than the feet touched the ground during the step.
    pub body_contact: bool,
    /// Whether links overlap at the end of the step; checked in evaluations, and in training if a termination
    /// needs it.
    pub self_collision: bool,
    /// Whether the episode began in the standing pose rather than in a state of the reference.
    pub standing_start: bool,
}

#[cfg(test)]
pub(crate) mod sample {
    //! An owned world in which a test can set every number.

    use super::{Frame, Signals};

    /// The owner of the data that [`Signals`] borrows; fields have the names and units of [`Signals`].
    #[allow(missing_docs)]
    pub struct Sample {
        pub time: f64,
        pub phase_step: f64,
        pub reference: Frame,
        pub command_speed: f64,
        pub base_height: f64,
        pub stature: f64,
        pub base_orientation: [f64; 4],
        pub base_velocity: [f64; 3],
        pub mean_velocity: [f64; 3],
        pub position: Vec<f64>,
        pub velocity: Vec<f64>,
        pub previous_velocity: Vec<f64>,
        pub torque: Vec<f64>,
        pub previous_torque: Vec<f64>,
        pub foot_force: [[f64; 3]; 2],
        pub previous_foot_force: [[f64; 3]; 2],
        pub foot_contact: [bool; 2],
        pub body_contact: bool,
        pub self_collision: bool,
        pub standing_start: bool,
    }

    impl Sample {
        /// A massless robot with this many joints that agrees with its reference in everything.
        pub fn new(joints: usize) -> Self {
            let still = vec![0.0; joints];
            Self {
                time: 1.0,
                phase_step: 0.01,
                reference: Frame {
                    position: still.clone(),
                    base_height: 1.0,
                    base_orientation: [1.0, 0.0, 0.0, 0.0],
                    ..Frame::default()
                },
                command_speed: 0.0,
                base_height: 1.0,
                stature: 1.0,
                base_orientation: [1.0, 0.0, 0.0, 0.0],
                base_velocity: [0.0; 3],
                mean_velocity: [0.0; 3],
                position: still.clone(),
                velocity: still.clone(),
                previous_velocity: still.clone(),
                torque: still.clone(),
                previous_torque: still,
                foot_force: [[0.0; 3]; 2],
                previous_foot_force: [[0.0; 3]; 2],
                foot_contact: [false; 2],
                body_contact: false,
                self_collision: false,
                standing_start: false,
            }
        }

        /// The signals of this world.
        pub fn signals(&self) -> Signals<'_> {
            Signals {
                step: 0.008,
                time: self.time,
                phase: 0.0,
                phase_step: self.phase_step,
                reference: &self.reference,
                command_speed: self.command_speed,
                base_position: [0.0, 0.0, self.base_height],
                base_height: self.base_height,
                stature: self.stature,
                base_orientation: self.base_orientation,
                base_velocity: self.base_velocity,
                mean_velocity: self.mean_velocity,
                base_rate: [0.0; 3],
                position: &self.position,
                velocity: &self.velocity,
                previous_velocity: &self.previous_velocity,
                torque: &self.torque,
                previous_torque: &self.previous_torque,
                foot_force: self.foot_force,
                previous_foot_force: self.previous_foot_force,
                foot_contact: self.foot_contact,
                body_contact: self.body_contact,
                self_collision: self.self_collision,
                standing_start: self.standing_start,
            }
        }
    }
}
