//! The episode of one robot without its world: everything in a control step except the physics.

use std::sync::Arc;

use super::attitude;
use super::command::Command;
use super::encoder::Encoder;
use super::interface::{End, Output, Sizes, Stance, Step, View};
use super::privileged::Privileged;
use super::scene::Scene;
use super::start::Place;
use super::stature::Stature;
use super::tally::{self, Tally};
use crate::control::Delay;
use crate::kinds::Signals;
use crate::kinds::motion::Frame;
use crate::kinds::observe::Readings;
use crate::kinds::randomize::{Draft, Push};
use crate::robot::{GRAVITY, SelfCollision};
use crate::sim::{EngineSettings, Seat, State};
use crate::stream::Stream;

/// The running episode of one robot of a scene. Its world is in a [`Seat`] that the caller owns, so that
/// several episodes can share an engine that advances their worlds together.
///
/// A control step, in this order: the action is clipped, mirrored back and converted into a command
/// ([`RobotEpisode::take`]); for each physics step the servo runs, the torque passes the delay line and the
/// motors limit it ([`RobotEpisode::drive`]), the engine advances the world, and the encoders are read
/// ([`RobotEpisode::sense`]); then time, phase, command and reference advance, and rewards and terminations
/// are evaluated ([`RobotEpisode::finish`]).
pub(super) struct RobotEpisode {
    scene: Arc<Scene>,
    state: State,
    encoder: Encoder,
    delay: Delay,
    motor: Vec<f64>,
    stature: Option<Stature>,
    guard: Option<SelfCollision>,
    pushes: Vec<Push>,
    pushed: [f64; 3],
    command: Command,
    memory: Vec<[f64; 2]>,
    tally: Tally,
    values: Vec<f64>,
    steps: u64,
    action: Vec<f64>,
    wanted: Vec<f64>,
    commanded: Vec<f64>,
    applied: Vec<f64>,
    /// Increment of the phase in the running control step.
    phase_step: f64,
    /// False once the engine refused the robot or the simulation diverged.
    intact: bool,
    now: Now,
}

/// Values for [`Signals`].
#[derive(Clone, Debug, Default)]
struct Now {
    time: f64,
    phase: f64,
    phase_step: f64,
    reference: Frame,
    command_speed: f64,
    base_height: f64,
    base_velocity: [f64; 3],
    mean_velocity: [f64; 3],
    base_rate: [f64; 3],
    previous_velocity: Vec<f64>,
    torque: Vec<f64>,
    previous_torque: Vec<f64>,
    foot_force: [[f64; 3]; 2],
    previous_foot_force: [[f64; 3]; 2],
    foot_contact: [bool; 2],
    body_contact: bool,
    self_collision: bool,
    standing_start: bool,
}

impl RobotEpisode {
    /// A new episode; the first call must be [`RobotEpisode::begin`].
    pub fn new(scene: Arc<Scene>) -> Self {
        let joints = scene.robot.joints();
        let still = vec![0.0; joints];
        let (noise, filter) = scene.encoder.clone();
        Self {
            state: State { position: still.clone(), velocity: still.clone(), ..State::default() },
            encoder: Encoder::new(joints, noise, filter, scene.settings.step),
            delay: Delay::default(),
            motor: vec![1.0; joints],
            stature: None,
            guard: None,
            pushes: Vec::new(),
            pushed: [0.0; 3],
            command: Command::begin(&scene.command, Stream::new("")),
            memory: vec![[0.0; 2]; scene.terminations.len()],
            tally: Tally::new(joints),
            values: vec![0.0; scene.rewards.len()],
            steps: 0,
            action: vec![0.0; scene.sizes.action],
            wanted: still.clone(),
            commanded: still.clone(),
            applied: still.clone(),
            phase_step: 0.0,
            intact: false,
            now: Now {
                previous_velocity: still.clone(),
                torque: still.clone(),
                previous_torque: still,
                ..Now::default()
            },
            scene,
        }
    }

    /// The scene of this episode.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The true state of the robot.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Commanded joint torques of the last control step in N m (mean over its physics steps, before delay
    /// and motor).
    pub fn torque(&self) -> &[f64] {
        &self.now.torque
    }

    /// Signals for the kinds, after the last control step.
    pub fn signals(&self) -> Signals<'_> {
        let (now, state) = (&self.now, &self.state);
        Signals {
            step: self.scene.rates.step,
            time: now.time,
            phase: now.phase,
            phase_step: now.phase_step,
            reference: &now.reference,
            command_speed: now.command_speed,
            base_position: state.base_position,
            base_height: now.base_height,
            stature: self.stature(),
            base_orientation: state.base_orientation,
            base_velocity: now.base_velocity,
            mean_velocity: now.mean_velocity,
            base_rate: now.base_rate,
            position: &state.position,
            velocity: &state.velocity,
            previous_velocity: &now.previous_velocity,
            torque: &now.torque,
            previous_torque: &now.previous_torque,
            foot_force: now.foot_force,
            previous_foot_force: now.previous_foot_force,
            foot_contact: now.foot_contact,
            body_contact: now.body_contact,
            self_collision: now.self_collision,
            standing_start: now.standing_start,
        }
    }

    /// Standing height of the episode's robot divided by the nominal robot's.
    fn stature(&self) -> f64 {
        self.stature.as_ref().map_or(1.0, Stature::ratio)
    }

    /// Computes the reference at the current phase, for the leg lengths of the episode's robot.
    fn refer(&mut self) {
        self.scene.motion.state_at(self.now.phase, &mut self.now.reference);
        if let Some(stature) = &mut self.stature {
            stature.follow(&mut self.now.reference);
        }
    }

    /// Starts an episode in the world of this seat; all its randomness comes from the stream of this name.
    pub fn begin(&mut self, stream: &str, seat: &mut Seat) {
        let scene = Arc::clone(&self.scene);
        let draft = self.draft(stream);
        let place = Place {
            robot: &draft.robot,
            nominal: &scene.robot,
            motion: &scene.motion,
            terrain: &scene.terrain,
        };
        let start = scene.start.draw(&place, &mut Stream::new(&format!("{stream}/start")));
        let settings = EngineSettings { friction: draft.friction, ..scene.settings.clone() };
        // If the engine refuses a drawn robot, the episode ends at its first step, as exploded.
        self.intact = seat.place(&draft.robot, &scene.terrain, &settings, &start.state).is_ok();
        self.state = start.state;
        if self.intact {
            seat.read(&mut self.state);
        }
        self.delay.reset(scene.robot.joints(), (scene.rates.delay * draft.delay).max(0.0));
        let seen = if start.at_rest { self.state.velocity.clone() } else { self.followed(start.phase) };
        let noise = Stream::new(&format!("{stream}/noise"));
        let State { position, velocity, .. } = &self.state;
        self.encoder.begin(position, velocity, &seen, &draft.joint_offset, noise);
        self.command = Command::begin(&scene.command, Stream::new(&format!("{stream}/command")));
        self.motor = draft.motor;
        self.stature = Stature::of(&scene.robot, &draft.robot);
        self.guard = scene.guarded.as_ref().map(|pairs| SelfCollision::new(&draft.robot, pairs.clone()));
        self.pushes = draft.pushes;
        self.pushed = [0.0; 3];
        self.steps = 0;
        self.memory.fill([0.0; 2]);
        self.values.fill(0.0);
        self.settle(start.phase, start.standing, draft.robot.total_mass() * GRAVITY);
    }

    /// The physics of an episode: nominal, or drawn from the randomization table, each row from its own
    /// stream.
    fn draft(&self, stream: &str) -> Draft {
        let scene = &self.scene;
        let episode = scene.rates.limit as f64 * scene.rates.step;
        let mut draft = Draft::new(scene.robot.clone(), scene.settings.friction, episode);
        for (name, row) in &scene.randomizations {
            row.apply(&mut draft, &mut Stream::new(&format!("{stream}/randomize/{name}")));
        }
        draft
    }

    /// Joint velocities in rad/s after the encoders' filter, for a robot that has followed the reference up
    /// to this phase. At a running cadence they lag far behind the true ones.
    fn followed(&self, phase: f64) -> Vec<f64> {
        let (scene, filter) = (&self.scene, &self.scene.encoder.1);
        // Six time constants: earlier samples have decayed to 1/400.
        let past = (6.0 / filter.share()).ceil() as usize;
        let step = scene.settings.step / scene.motion.period;
        let mut velocity = Vec::with_capacity(scene.robot.joints());
        scene.motion.velocity_at(phase - past as f64 * step, &mut velocity);
        let mut seen = velocity.clone();
        for index in (0..past).rev() {
            scene.motion.velocity_at(phase - index as f64 * step, &mut velocity);
            seen.iter_mut().zip(&velocity).for_each(|(seen, velocity)| *seen = filter.next(*seen, *velocity));
        }
        seen
    }

    /// Initializes the episode from the state, the phase and the reference.
    fn settle(&mut self, phase: f64, standing: bool, weight: f64) {
        let now = &mut self.now;
        (now.time, now.phase, now.phase_step, now.standing_start) = (0.0, phase, 0.0, standing);
        self.refer();
        let now = &mut self.now;
        now.foot_contact = if standing { [true; 2] } else { now.reference.contact };
        let carrying = now.foot_contact.iter().filter(|contact| **contact).count().max(1) as f64;
        now.foot_force =
            now.foot_contact.map(|contact| [0.0, 0.0, if contact { weight / carrying } else { 0.0 }]);
        now.previous_foot_force = now.foot_force;
        (now.body_contact, now.self_collision) = (false, false);
        now.previous_velocity.copy_from_slice(&self.state.velocity);
        now.torque.fill(0.0);
        now.previous_torque.fill(0.0);
        now.command_speed = self.command.at(&self.scene.command, 0.0);
        self.look();
        self.now.mean_velocity = self.now.base_velocity;
    }

    /// Computes base height and velocities in the heading frame from the state.
    fn look(&mut self) {
        let state = &self.state;
        let yaw = attitude::yaw(state.base_orientation);
        self.now.base_velocity = attitude::turned(state.base_velocity, -yaw);
        self.now.base_rate = attitude::turned(state.base_rate, -yaw);
        let [x, y, z] = state.base_position;
        self.now.base_height = z - self.scene.terrain.height(x, y);
    }

    /// Begins a control step with the actor's (unclipped) outputs: mirrors them back and converts them into a
    /// command.
    pub fn take(&mut self, action: &[f32]) {
        let scene = &self.scene;
        for (own, given) in self.action.iter_mut().zip(action) {
            *own = if given.is_finite() { f64::from(*given) } else { 0.0 };
        }
        if scene.observation.reflects(self.now.phase) {
            scene.observation.reflect(&mut self.action);
        }
        let joints = scene.robot.joints();
        scene.law.command(&self.action[..joints], &mut self.wanted);
        let faster = scene.rates.modulation.map_or(0.0, |gain| gain * self.action[joints].clamp(0.0, 1.0));
        self.phase_step = scene.rates.step * (1.0 + faster) / scene.motion.period;
        self.now.previous_velocity.copy_from_slice(&self.state.velocity);
        self.now.previous_foot_force = self.now.foot_force;
        std::mem::swap(&mut self.now.previous_torque, &mut self.now.torque);
        self.tally.clear();
    }

    /// Passes the torques of a physics step, the `tick`-th of the control step, to the world.
    pub fn drive(&mut self, tick: usize, seat: &mut Seat) {
        if !self.intact {
            return;
        }
        let (law, rates) = (&self.scene.law, &self.scene.rates);
        if !self.pushes.is_empty() {
            let time = self.now.time + tick as f64 * self.scene.settings.step;
            let force = pushing(&self.pushes, [time, time + self.scene.settings.step]);
            if force != self.pushed {
                seat.push(force);
                self.pushed = force;
            }
        }
        if tick.is_multiple_of(rates.servo) && law.reads_encoders() {
            law.torque(&self.wanted, self.encoder.position(), self.encoder.difference(), &mut self.commanded);
        } else if tick.is_multiple_of(rates.servo) {
            // The servo's readings have the encoders' offset, but not their noise.
            for (shifted, (position, offset)) in
                self.applied.iter_mut().zip(self.state.position.iter().zip(self.encoder.offset()))
            {
                *shifted = position + offset;
            }
            law.torque(&self.wanted, &self.applied, &self.state.velocity, &mut self.commanded);
        }
        self.applied.copy_from_slice(&self.commanded);
        self.delay.pass(&mut self.applied);
        self.applied.iter_mut().zip(&self.motor).for_each(|(torque, motor)| *torque *= motor);
        law.restrict(&self.state.velocity, &mut self.applied);
        seat.apply(&self.applied);
    }

    /// Reads the world after a physics step.
    pub fn sense(&mut self, seat: &Seat) {
        self.intact = self.intact && seat.is_sane();
        if self.intact {
            seat.read(&mut self.state);
            self.encoder.sample(&self.state.position);
            self.tally.add(&seat.contacts(), &self.commanded);
        }
    }

    /// Ends a control step: returns the reward, and whether the episode ends.
    pub fn finish(&mut self) -> Step {
        if !self.intact {
            self.values.fill(0.0);
            return Step { reward: 0.0, end: Some(End::Exploded) };
        }
        self.advance();
        let end = self.end();
        if let Some(End::Terminated(_)) = end {
            self.values.fill(0.0);
            return Step { reward: 0.0, end };
        }
        Step { reward: self.reward(), end }
    }

    /// Everything after the physics: time, phase, reference, forces.
    fn advance(&mut self) {
        self.steps += 1;
        let scene = Arc::clone(&self.scene);
        let now = &mut self.now;
        now.time = self.steps as f64 * scene.rates.step;
        now.phase_step = self.phase_step;
        now.phase += self.phase_step;
        now.phase -= libm::floor(now.phase);
        self.refer();
        let now = &mut self.now;
        now.command_speed = self.command.at(&scene.command, now.time);
        now.foot_force = self.tally.foot_force();
        now.foot_contact = tally::contact(&now.foot_force);
        now.body_contact = self.tally.body_contact();
        now.self_collision =
            self.guard.as_mut().is_some_and(|guard| guard.find(&self.state.position).is_some());
        self.tally.torque(&mut now.torque);
        if self.steps == 1 {
            // No command precedes the first step, so no change is penalized.
            now.previous_torque.copy_from_slice(&now.torque);
        }
        self.look();
        let now = &mut self.now;
        for (mean, velocity) in now.mean_velocity.iter_mut().zip(now.base_velocity) {
            *mean = scene.averaging.next(*mean, velocity);
        }
    }

    /// Why the episode ends here, or `None`.
    fn end(&mut self) -> Option<End> {
        let mut memory = std::mem::take(&mut self.memory);
        let signals = self.signals();
        let mut cause = None;
        for (index, (term, memory)) in self.scene.terminations.iter().zip(&mut memory).enumerate() {
            // Every term sees every step, so that its state stays correct.
            if term.ends(&signals, memory) && cause.is_none() {
                cause = Some(End::Terminated(index));
            }
        }
        self.memory = memory;
        cause.or((self.steps >= self.scene.rates.limit).then_some(End::TimeOut))
    }

    /// Computes the term values and returns their sum.
    fn reward(&mut self) -> f64 {
        let mut values = std::mem::take(&mut self.values);
        let signals = self.signals();
        for (value, (weight, term)) in values.iter_mut().zip(&self.scene.rewards) {
            *value = weight * term.value(&signals);
        }
        self.values = values;
        self.values.iter().sum()
    }
}

/// Mean force in N between two times in s: a push that begins or ends within a physics step counts in
/// proportion, so that every push has its exact impulse.
fn pushing(pushes: &[Push], [from, to]: [f64; 2]) -> [f64; 3] {
    pushes.iter().fold([0.0; 3], |sum, push| {
        let share = (push.end.min(to) - push.start.max(from)).max(0.0) / (to - from);
        std::array::from_fn(|axis| sum[axis] + share * push.force[axis])
    })
}

impl View for RobotEpisode {
    fn sizes(&self) -> Sizes {
        self.scene.sizes
    }

    fn observe(&self, observation: &mut [f32]) {
        let readings = Readings {
            attitude: attitude::angles(self.state.base_orientation),
            position: self.encoder.position(),
            velocity: self.encoder.velocity(),
            phase: self.now.phase,
            command_speed: self.now.command_speed,
            mirror: None,
        };
        self.scene.observation.write(&readings, observation);
    }

    fn observe_truths(&self, truths: &mut [f32]) {
        if !truths.is_empty() {
            let mismatch =
                self.scene.schedule.map_or(0.0, |index| self.memory[index][0].max(self.memory[index][1]));
            let reflected = self.scene.observation.reflects(self.now.phase);
            let nominal = self.scene.privileged;
            let privileged = Privileged { height: nominal.height * self.stature(), ..nominal };
            privileged.write(&self.signals(), mismatch, reflected, truths);
        }
    }

    fn terms(&self) -> &[String] {
        &self.scene.reward_names
    }

    fn term_values(&self) -> &[f64] {
        &self.values
    }

    fn term_ranges(&self) -> &[[f64; 2]] {
        &self.scene.reward_ranges
    }

    fn outputs(&self) -> &[Output] {
        &self.scene.outputs
    }

    fn stance(&self) -> Option<Stance> {
        Some(Stance { feet: self.now.foot_contact, reference: self.now.reference.contact })
    }

    fn causes(&self) -> &[String] {
        &self.scene.causes
    }
}
