//! Time of a physics step of the spec's robot on flat ground, with as many robots as the engine advances
//! together: held in its default pose, and moving along its reference.

use std::borrow::Cow;
use std::hint::black_box;
use std::sync::Arc;

use super::median;
use crate::env::Blueprint;
use crate::kinds::motion::{Frame, Motion};
use crate::learn::clock::timed;
use crate::robot::Robot;
use crate::sim::{self, Engine, EngineError, EngineSettings, State, Terrain, Worlds};

/// Physics steps per timed stretch.
const STEPS: usize = 1000;
/// Stretches of each kind, measured alternately.
const STRETCHES: usize = 9;
/// How long in s a robot follows its reference before a reset; without a policy it may fall later.
const SPELL: f64 = 0.5;

/// CPU time per robot and step, in microseconds.
pub(super) struct Steps {
    /// Standing, as in an environment: setting torques, step, reading state and contacts.
    pub whole: f64,
    /// Standing, the engine's step alone.
    pub bare: f64,
    /// Moving, the engine's step alone.
    pub moving: f64,
}

/// Measures all three.
pub(super) fn measure(blueprint: &Blueprint, engine: &Arc<dyn Engine>) -> Result<Steps, EngineError> {
    let mut robots = Robots::new(blueprint, engine)?;
    let (mut whole, mut bare, mut moving) = (Vec::new(), Vec::new(), Vec::new());
    robots.stand(STEPS, |worlds| worlds.advance());
    for _ in 0..STRETCHES {
        whole.push(timed(|| robots.stand(STEPS, |worlds| worlds.advance())).1);
        let mut inside = 0.0;
        robots.stand(STEPS, |worlds| inside += timed(|| worlds.advance()).1);
        let ((), clock) = timed(|| (0..STEPS).for_each(|_| _ = black_box(timed(|| ()))));
        bare.push(inside - clock / 2.0);
        let mut inside = 0.0;
        robots.walk(STEPS, |worlds| inside += timed(|| worlds.advance()).1)?;
        moving.push(inside - clock / 2.0);
        robots.rest()?;
    }
    let us = |seconds: Vec<f64>| 1e6 * median(seconds) / (STEPS * robots.members.len()) as f64;
    Ok(Steps { whole: us(whole), bare: us(bare), moving: us(moving) })
}

/// Robots under position control with their own gains.
struct Robots<'a> {
    robot: &'a Robot,
    motion: Cow<'a, Motion>,
    settings: EngineSettings,
    worlds: Box<dyn Worlds>,
    members: Vec<Member>,
    frame: Frame,
}

#[derive(Clone)]
struct Member {
    state: State,
    torque: Vec<f64>,
    /// Phase of the cycle at which it starts to follow the reference.
    phase: f64,
}

impl<'a> Robots<'a> {
    fn new(blueprint: &'a Blueprint, engine: &Arc<dyn Engine>) -> Result<Self, EngineError> {
        let (robot, width) = (&blueprint.robot, engine.width());
        let member = |index: usize| Member {
            state: State::default(),
            torque: vec![0.0; robot.joints()],
            phase: index as f64 / width as f64,
        };
        let mut robots = Self {
            robot,
            motion: blueprint.reference(),
            settings: EngineSettings {
                step: 1.0 / blueprint.physics_rate(),
                friction: 1.0,
                contact_time: None,
            },
            worlds: sim::worlds(engine, width),
            members: (0..width).map(member).collect(),
            frame: Frame::default(),
        };
        robots.rest()?;
        Ok(robots)
    }

    /// Puts all robots in their initial state.
    fn rest(&mut self) -> Result<(), EngineError> {
        for (slot, member) in self.members.iter_mut().enumerate() {
            member.state = State::of(self.robot);
            self.worlds.place(slot, self.robot, &Terrain::Flat, &self.settings, &member.state)?;
        }
        Ok(())
    }

    /// Physics steps as in an environment, in the default pose.
    fn stand(&mut self, steps: usize, mut advance: impl FnMut(&mut dyn Worlds)) {
        let pose = self.robot.default_pose();
        for _ in 0..steps {
            for (slot, member) in self.members.iter_mut().enumerate() {
                pull(self.robot, &pose, member);
                self.worlds.apply(slot, &member.torque);
            }
            advance(self.worlds.as_mut());
            for (slot, member) in self.members.iter_mut().enumerate() {
                black_box(self.worlds.is_sane(slot));
                self.worlds.read(slot, &mut member.state);
                black_box(self.worlds.contacts(slot));
            }
        }
    }

    /// Physics steps towards the poses of the reference, each robot at its own phase of the cycle.
    fn walk(&mut self, steps: usize, mut advance: impl FnMut(&mut dyn Worlds)) -> Result<(), EngineError> {
        let (step, spell) = (self.settings.step, (SPELL / self.settings.step).ceil() as usize);
        for index in 0..steps {
            for (slot, member) in self.members.iter_mut().enumerate() {
                let time = (index % spell) as f64 * step;
                self.motion.state_at(member.phase + time / self.motion.period, &mut self.frame);
                if index % spell == 0 {
                    let frame = &self.frame;
                    member.state = State {
                        base_position: [0.0, 0.0, frame.base_height],
                        base_orientation: frame.base_orientation,
                        base_velocity: frame.base_velocity,
                        base_rate: frame.base_rate,
                        position: frame.position.clone(),
                        velocity: frame.velocity.clone(),
                    };
                    self.worlds.place(slot, self.robot, &Terrain::Flat, &self.settings, &member.state)?;
                }
                pull(self.robot, &self.frame.position, member);
                self.worlds.apply(slot, &member.torque);
            }
            advance(self.worlds.as_mut());
            (self.members.iter_mut().enumerate())
                .for_each(|(slot, member)| self.worlds.read(slot, &mut member.state));
        }
        Ok(())
    }
}

/// Computes the torques that drive a robot to a pose.
fn pull(robot: &Robot, pose: &[f64], member: &mut Member) {
    for (index, link) in robot.links.iter().enumerate() {
        let joint = &link.joint;
        let pull = joint.stiffness_gain * (pose[index] - member.state.position[index]);
        let torque = pull - joint.damping_gain * member.state.velocity[index];
        member.torque[index] = torque.clamp(-joint.effort_limit, joint.effort_limit);
    }
}
