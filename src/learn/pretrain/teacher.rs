//! The teacher: draws states of the robot and computes the actions of a good policy in them.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::control::law::Law;
use crate::env::Observation;
use crate::kinds::action::Action;
use crate::kinds::motion::{Frame, Motion};
use crate::kinds::observe::Readings;
use crate::kinds::pretrain::{Lesson, PhaseLabel, Pretraining};
use crate::kinds::task::Task;
use crate::robot::{GravityCompensation, Robot, Weighting};
use crate::spec::{Sampler, Section, Table};
use crate::stream::Stream;

use super::drawn::{Drawn, Drive};
use super::reference::Reference;
use super::tracking::Tracking;

/// Draws labelled states. Each thread has its own teacher.
#[derive(Clone, Debug)]
pub struct Teacher {
    observation: Observation,
    law: Law,
    gravity: GravityCompensation,
    reference: Option<Reference>,
    rule: Rule,
    noise: Noise,
    joints: Vec<Drive>,
    speed: Sampler,
    phase_action: bool,
    /// Whether the label of the phase action is random, as in the paper.
    random_phase: bool,
    state: State,
}

/// The rule that gives the labels.
#[derive(Clone, Debug)]
enum Rule {
    /// Hold still against gravity.
    Gravity {
        /// Share of the samples near the default pose.
        standing_share: f64,
        /// Height above the lower sole, in m, up to which a sole still carries load.
        contact_height: f64,
    },
    /// Follow the reference motion compliantly.
    Tracking(Box<Tracking>),
}

/// Widths of the distributions of states.
#[derive(Clone, Debug)]
struct Noise {
    position: Sampler,
    velocity: Vec<f64>,
    tilt: Vec<f64>,
}

/// Buffers of one sample.
#[derive(Clone, Debug, Default)]
struct State {
    frame: Frame,
    seen: Frame,
    position: Vec<f64>,
    /// Deviation of the joint velocities from the reference.
    swing: Vec<f64>,
    velocity: Vec<f64>,
    seen_velocity: Vec<f64>,
    torque: Vec<f64>,
    action: Vec<f64>,
}

impl Teacher {
    /// The teacher of a decoded spec: reads `pretrain`, `observe`, `action`, `physics.rate`, `task.command`
    /// and `learn.symmetry`.
    pub fn new(fields: &Table, robot: &Robot, motion: Option<&Motion>) -> Self {
        let sections = Section::new(fields);
        let lesson: Pretraining = sections.part().expect("the spec has a pre-training");
        let action: Action = sections.part().expect("the spec has an action");
        let observation = Observation::new(fields, robot);
        let drive = |index: usize| {
            let joint = &robot.links[index].joint;
            Drive {
                effort: joint.effort_limit,
                stiffness: joint.stiffness_gain,
                damping: joint.damping_gain,
                armature: joint.armature,
                default_position: joint.default_position,
            }
        };
        Self {
            noise: Noise::new(lesson.lesson(), &observation, robot),
            observation,
            law: Law::new(&action, robot),
            gravity: GravityCompensation::new(robot, Weighting::EffortLimits),
            reference: motion.map(|motion| Reference::new(sections, motion)),
            rule: Rule::new(&lesson, robot),
            joints: (0..robot.joints()).map(drive).collect(),
            speed: Task::commanded(sections).map_or(Sampler::Constant(0.0), |command| command.speed),
            phase_action: action.phase_modulation(),
            random_phase: lesson.phase_label() == PhaseLabel::Random,
            state: State::default(),
        }
    }

    /// Length of the actor's input.
    pub fn inputs(&self) -> usize {
        self.observation.len()
    }

    /// Length of the actor's output.
    pub fn outputs(&self) -> usize {
        self.joints.len() + usize::from(self.phase_action)
    }

    /// Number of outputs that stand for a torque; one more is the phase action.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// Torque in N m (for small errors) per unit of each joint's action.
    pub fn torque_per_action(&self) -> Vec<f64> {
        let units = self.law.units().zip(self.law.gains());
        units.map(|(unit, (stiffness, _))| if stiffness > 0.0 { stiffness * unit } else { unit }).collect()
    }

    /// Draws a state, and writes the actor's input and the action to learn. The phase action's label is zero
    /// unless it is random.
    pub fn draw(&mut self, stream: &mut Stream, input: &mut [f32], label: &mut [f32]) {
        let shown_phase = stream.uniform();
        let attitude = self.pose(shown_phase, stream);
        self.torques(&attitude);
        let State { position, velocity, seen_velocity, torque, action, .. } = &mut self.state;
        for (torque, drive) in torque.iter_mut().zip(&self.joints) {
            *torque = torque.clamp(-drive.effort, drive.effort);
        }
        action.resize(self.joints.len(), 0.0);
        self.law.action(torque, position, velocity, action);
        if self.observation.reflects(shown_phase) {
            self.observation.reflect(action);
        }
        label.fill(0.0);
        label.iter_mut().zip(action).for_each(|(label, action)| *label = *action as f32);
        let command_speed = stream.draw(&self.speed);
        let readings = Readings {
            attitude,
            position,
            velocity: seen_velocity,
            phase: shown_phase,
            command_speed,
            mirror: None,
        };
        self.observation.write(&readings, input);
        if self.random_phase && self.phase_action {
            label[self.joints.len()] = stream.uniform() as f32;
        }
    }

    /// Draws joints and base; returns the base's fixed-XYZ angles.
    fn pose(&mut self, shown_phase: f64, stream: &mut Stream) -> [f64; 3] {
        let State { frame, seen, position, swing, velocity, seen_velocity, .. } = &mut self.state;
        // Gravity compensation ignores the phase, so its pose is drawn at another one.
        let (standing, phase) = match &self.rule {
            Rule::Gravity { standing_share, .. } => (stream.uniform() < *standing_share, stream.uniform()),
            Rule::Tracking(_) => (false, shown_phase),
        };
        match &self.reference {
            Some(reference) if !standing => {
                reference.motion.at(phase, frame);
                reference.seen.at(phase, seen);
            }
            _ => {
                *frame = standing_frame(&self.joints);
                seen.clone_from(frame);
            }
        }
        let width = stream.draw(&self.noise.position);
        position.clear();
        position.extend(frame.position.iter().map(|centre| centre + width * stream.normal()));
        swing.clear();
        swing.extend(self.noise.velocity.iter().map(|width| width * stream.normal()));
        let add = |frame: &Frame, velocity: &mut Vec<f64>| {
            velocity.clear();
            velocity.extend(frame.velocity.iter().zip(&*swing).map(|(centre, swing)| centre + swing));
        };
        add(frame, velocity);
        add(seen, seen_velocity);
        let upright = crate::env::attitude::angles(frame.base_orientation);
        std::array::from_fn(|axis| upright[axis] + self.noise.tilt[axis] * stream.normal())
    }

    /// Computes the torques of the drawn state.
    fn torques(&mut self, attitude: &[f64; 3]) {
        let base = Isometry3::from_parts(Translation3::identity(), rotation(attitude));
        let State { frame, position, swing, torque, .. } = &mut self.state;
        torque.clear();
        match &mut self.rule {
            Rule::Gravity { contact_height, .. } => {
                torque.extend(&self.gravity.hold_by_height(&base, position, *contact_height).torque);
            }
            Rule::Tracking(tracking) => {
                let drawn = Drawn { base, yaw: attitude[2], position, swing };
                tracking.torques(&mut self.gravity, &self.joints, &drawn, frame, torque);
            }
        }
    }
}

impl Rule {
    fn new(lesson: &Pretraining, robot: &Robot) -> Self {
        match lesson {
            Pretraining::Tracking(keys) => Self::Tracking(Box::new(Tracking::new(keys, robot))),
            Pretraining::GravityCompensation(keys) => {
                Self::Gravity { standing_share: keys.standing_share, contact_height: keys.contact_height }
            }
        }
    }
}

impl Noise {
    fn new(lesson: &Lesson, observation: &Observation, robot: &Robot) -> Self {
        let share = lesson.velocity_noise;
        let scales = observation
            .inputs()
            .iter()
            .filter(|input| input.name == "joint_velocity")
            .map(|input| input.scale);
        let mut velocity: Vec<f64> = scales.map(|scale| share * scale).collect();
        // An actor without velocities in its input is trained on resting joints.
        velocity.resize(robot.joints(), 0.0);
        let tilt = &lesson.tilt_noise;
        let tilt = tilt.iter().copied().cycle().take(if tilt.is_empty() { 0 } else { 3 }).collect();
        Self { position: lesson.position_noise.clone(), velocity, tilt }
    }
}

/// The default pose as a frame of a motion: at rest on both feet.
fn standing_frame(joints: &[Drive]) -> Frame {
    Frame {
        position: joints.iter().map(|drive| drive.default_position).collect(),
        velocity: vec![0.0; joints.len()],
        acceleration: vec![0.0; joints.len()],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [true, true],
        ..Frame::default()
    }
}

/// The rotation of fixed-XYZ angles: Rz(yaw) Ry(pitch) Rx(roll).
fn rotation(angles: &[f64; 3]) -> UnitQuaternion<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(|angle| libm::sincos(0.5 * angle));
    UnitQuaternion::from_quaternion(Quaternion::new(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ))
}
#[cfg(test)]
mod tests;
