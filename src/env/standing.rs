//! The reward of a robot that follows given frames exactly, and the return of one that stands still: computed
//! from the spec, without physics.
//!
//! Joints and base are those of the frame; torques and foot forces are those of gravity compensation, times
//! 1 + a_z / g for the vertical acceleration of the base.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::blueprint::Blueprint;
use super::command::CommandPlan;
use super::{scene, tally};
use crate::kinds::Signals;
use crate::kinds::motion::Frame;
use crate::kinds::reward::Rewards;
use crate::robot::{GRAVITY, GravityCompensation, Robot, Weighting};
use crate::spec::typed::InSection;

/// One control step of a robot that follows a frame exactly.
#[derive(Clone, Debug, Default)]
pub(super) struct Moment {
    frame: Frame,
    torque: Vec<f64>,
    force: [[f64; 3]; 2],
}

impl Moment {
    /// The step at a frame.
    pub fn at(frame: &Frame, compensation: &mut GravityCompensation) -> Self {
        let [w, x, y, z] = frame.base_orientation;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let base = Isometry3::from_parts(Translation3::new(0.0, 0.0, frame.base_height), turn);
        let share = (1.0 + frame.base_acceleration[2] / GRAVITY).max(0.0);
        let balance = compensation.hold(&base, &frame.position, frame.contact);
        Self {
            frame: frame.clone(),
            torque: balance.torque.iter().map(|torque| share * torque).collect(),
            force: [0, 1].map(|foot| [0, 1, 2].map(|axis| share * balance.wrench[foot][axis])),
        }
    }

    /// A step of a robot at rest in its default pose on flat ground.
    pub fn standing(robot: &Robot) -> Self {
        let still = Frame {
            position: robot.default_pose(),
            velocity: vec![0.0; robot.joints()],
            base_height: robot.standing_height,
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            contact: [true; 2],
            ..Frame::default()
        };
        Self::at(&still, &mut GravityCompensation::new(robot, Weighting::EffortLimits))
    }

    /// What the reward terms read in this step of `step` seconds, with the step before it, the reference and
    /// the commanded speed in m/s.
    pub fn signals<'a>(
        &'a self,
        before: &'a Self,
        step: f64,
        reference: &'a Frame,
        command: f64,
    ) -> Signals<'a> {
        Signals {
            step,
            time: 1.0,
            phase: 0.0,
            phase_step: 0.0,
            reference,
            command_speed: command,
            base_position: [0.0, 0.0, self.frame.base_height],
            base_height: self.frame.base_height,
            stature: 1.0,
            base_orientation: self.frame.base_orientation,
            base_velocity: self.frame.base_velocity,
            mean_velocity: self.frame.base_velocity,
            base_rate: self.frame.base_rate,
            position: &self.frame.position,
            velocity: &self.frame.velocity,
            previous_velocity: &before.frame.velocity,
            torque: &self.torque,
            previous_torque: &before.torque,
            foot_force: self.force,
            previous_foot_force: before.force,
            foot_contact: tally::contact(&self.force),
            body_contact: false,
            self_collision: false,
            standing_start: false,
        }
    }
}

impl Blueprint {
    /// Undiscounted return of a full-length episode in which the nominal robot holds its default pose on flat
    /// ground, averaged over the commanded speeds of the training. The reference motion advances at its nominal
    /// rate; terminations are ignored.
    pub fn standing_return(&self) -> f64 {
        let (motion, step) = (self.reference(), 1.0 / self.control_rate());
        let (rewards, _) = scene::rewards(self.section(Rewards::SECTION));
        let speeds = CommandPlan::new(&self.part()).speeds();
        let moment = Moment::standing(&self.robot);
        let steps = (self.episode() * self.control_rate()).round().max(1.0) as u64;
        let start = self.starts()[0];
        let mut frame = Frame::default();
        let mut sum = 0.0;
        for index in 1..=steps {
            motion.state_at(start + index as f64 * step / motion.period, &mut frame);
            for speed in &speeds {
                let signals = moment.signals(&moment, step, &frame, *speed);
                sum += rewards.iter().map(|(weight, term)| weight * term.value(&signals)).sum::<f64>();
            }
        }
        sum / speeds.len() as f64
    }
}
