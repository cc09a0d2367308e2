//! The protocol `episodes`: the deterministic policy in a number of independent episodes.
//!
//! Episodes run in parallel on threads; each depends only on its own random stream, so the result does not
//! depend on the number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use super::conditions::Condition;
use super::conditions::scaled;
use super::follower::{Count, Follower, Lasting, Measured};
use super::meter::Meter;
use super::protocol::Protocol;
use crate::crash;
use crate::env::{Blueprint, BlueprintError, End, Mode, Randomized, RobotEnvironment, Trial, ground};
use crate::kinds::task::Task;
use crate::learn::inference::{Inference, Scratch};
use crate::learn::network::Network;
use crate::outcome::{EXPLODED, Episode, Evaluation};
use crate::robot::{Kinematics, Leg};
use crate::sim::Engine;
use crate::spec::Section;
use crate::stream::Stream;

/// A policy in its environment, to be evaluated in an engine.
#[derive(Clone)]
pub struct Subject<'a> {
    /// The actor.
    pub network: &'a Network,
    /// Its environment.
    pub blueprint: &'a Blueprint,
    /// The engine.
    pub engine: Arc<dyn Engine>,
    /// Time constant of soft contacts in s; `None` is the engine's default.
    pub contact_time: Option<f64>,
}

/// Why an evaluation failed.
#[derive(Debug, thiserror::Error)]
pub enum EvaluationError {
    /// The environment cannot be built.
    #[error(transparent)]
    Blueprint(#[from] BlueprintError),
    /// The network has other inputs or outputs than the environment (E0502).
    #[error("the policy has {found} {side}, the environment {expected}")]
    Shape {
        /// `inputs` or `outputs`.
        side: &'static str,
        /// Size in the environment.
        expected: usize,
        /// Size in the network.
        found: usize,
    },
    /// The evaluation was interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// Runs the episodes on up to `threads` threads. `progress` receives the number of finished episodes and
/// returns whether to continue.
pub fn episodes(
    subject: &Subject,
    protocol: &Protocol,
    threads: usize,
    progress: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Evaluation, EvaluationError> {
    followed(subject, protocol, threads, &Count(progress))
}

/// As [`episodes`], with a follower that may know some of the episodes from an earlier run.
pub fn followed(
    subject: &Subject,
    protocol: &Protocol,
    threads: usize,
    follower: &dyn Follower,
) -> Result<Evaluation, EvaluationError> {
    check(subject)?;
    let blueprint = protocol.ground(subject.blueprint)?;
    let course = Course::new(Subject { blueprint: &blueprint, ..subject.clone() }, protocol);
    let mut evaluation = Evaluation {
        engine: subject.engine.name().into(),
        physics_rate: subject.blueprint.physics_rate(),
        control_rate: subject.blueprint.control_rate(),
        command: course.command,
        time_limit: protocol.time_limit.unwrap_or(subject.blueprint.episode()),
        obstacle: course.obstacle,
        ..Evaluation::default()
    };
    for (episode, trace) in all(&course, threads, follower)? {
        evaluation.episodes.push(episode);
        evaluation.trace = trace.unwrap_or(evaluation.trace);
    }
    Ok(evaluation)
}

/// Every episode in order: those that the follower knows, and the others as measured now.
fn all(course: &Course, threads: usize, follower: &dyn Follower) -> Result<Vec<Measured>, EvaluationError> {
    let count = course.protocol.conditions.len();
    let mut measured = follower.known();
    measured.retain(|index, _| *index < count);
    let pending: Vec<usize> = (0..count).filter(|index| !measured.contains_key(index)).collect();
    let (done, watch) = (AtomicUsize::new(measured.len()), Patience::new(follower));
    let told = |index: usize, result: &Result<Measured, EvaluationError>| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        result.as_ref().is_ok_and(|measured| follower.takes(index, measured, done))
    };
    for (index, result) in in_parallel(&pending, threads, &|index| course.run(index, &watch), &told) {
        measured.insert(index, result?);
    }
    if measured.len() < count {
        return Err(EvaluationError::Interrupted);
    }
    Ok(measured.into_values().collect())
}

/// Processes these indices on up to `threads` threads. `told` receives each result and returns whether to
/// continue; if it returns false, the results are incomplete.
fn in_parallel<T: Send>(
    indices: &[usize],
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
    told: &(dyn Fn(usize, &T) -> bool + Sync),
) -> Vec<(usize, T)> {
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let part = crash::part();
    let share = || {
        part.join();
        let mut results = Vec::new();
        while let Some(index) = indices.get(next.fetch_add(1, Ordering::Relaxed)).copied() {
            if stopped.load(Ordering::Relaxed) {
                break;
            }
            let result = work(index);
            if !told(index, &result) {
                stopped.store(true, Ordering::Relaxed);
            }
            results.push((index, result));
        }
        results
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(indices.len())).map(|_| scope.spawn(share)).collect();
        let mut results = share();
        for other in others {
            results.extend(crash::joined(other.join()));
        }
        results
    })
}

/// Control steps between two checks of the interruption and the clock.
const LOOK: u64 = 16;

/// Ends episodes after an interruption, and reports the first long one.
struct Patience<'a> {
    follower: &'a dyn Follower,
    told: AtomicBool,
}

impl<'a> Patience<'a> {
    fn new(follower: &'a dyn Follower) -> Self {
        Self { follower, told: AtomicBool::new(false) }
    }

    fn look(&self, index: usize, course: Lasting) -> Result<(), EvaluationError> {
        if self.follower.is_interrupted() {
            return Err(EvaluationError::Interrupted);
        }
        let is_long = course.wall_s >= self.follower.patience().as_secs_f64();
        if is_long && !self.told.swap(true, Ordering::Relaxed) {
            self.follower.lasts(index, course);
        }
        Ok(())
    }
}

/// Refuses a network whose input or output has another length than the environment's.
fn check(subject: &Subject) -> Result<(), EvaluationError> {
    let sizes = subject.blueprint.sizes();
    let sides = [
        ("inputs", sizes.observation, subject.network.inputs()),
        ("outputs", sizes.action, subject.network.outputs()),
    ];
    match sides.into_iter().find(|(_, expected, found)| expected != found) {
        Some((side, expected, found)) => Err(EvaluationError::Shape { side, expected, found }),
        None => Ok(()),
    }
}

/// The middle of the task's range of speeds in m/s; `None` for a task without a command.
fn usual_command(blueprint: &Blueprint) -> Option<f64> {
    let [low, high] = Task::commanded(Section::new(&blueprint.fields))?.speed.bounds();
    Some(0.5 * (low + high))
}

/// What the episodes of an evaluation share.
struct Course<'a> {
    subject: Subject<'a>,
    protocol: &'a Protocol,
    /// The task's default command.
    usual: Option<f64>,
    /// The command of all episodes if it is constant.
    command: Option<f64>,
    /// The start phases, used in turn.
    starts: Vec<f64>,
    /// Range of the obstacle along x.
    obstacle: Option<[f64; 2]>,
    /// The joints that pitch the ankles.
    ankles: Vec<usize>,
    joints: Vec<String>,
}

impl<'a> Course<'a> {
    fn new(subject: Subject<'a>, protocol: &'a Protocol) -> Self {
        let robot = &subject.blueprint.robot;
        let legs = [0, 1].into_iter().filter_map(|side| Leg::pitches(robot, side));
        let usual = usual_command(subject.blueprint);
        Self {
            usual,
            command: protocol.command(usual),
            starts: subject.blueprint.starts(),
            obstacle: ground::terrain(&subject.blueprint.part()).obstacle(),
            ankles: legs.map(|[_, _, (ankle, _)]| ankle).collect(),
            joints: robot.links.iter().map(|link| link.joint.name.clone()).collect(),
            subject,
            protocol,
        }
    }

    /// The condition of an episode, with the task's default command if it has none, and with the rows that
    /// scale its parameters.
    fn condition(&self, index: usize) -> Condition {
        let mut condition = self.protocol.conditions[index].clone();
        condition.command = condition.command.or(self.usual);
        if !condition.parameters.is_empty() {
            condition.randomized = Randomized::By(Arc::new(scaled(&condition.parameters)));
        }
        condition
    }

    fn environment(&self, index: usize, condition: &Condition) -> Result<RobotEnvironment, BlueprintError> {
        let Subject { blueprint, engine, contact_time, .. } = &self.subject;
        let trial = Trial {
            command: condition.command,
            phase: self.starts[index % self.starts.len()],
            perturbation: self.protocol.perturbation,
            time_limit: self.protocol.time_limit,
            noise: self.protocol.noise,
            randomized: condition.randomized.clone(),
            contact_time: *contact_time,
        };
        blueprint.environment(engine.clone(), &Mode::Evaluation(trial))
    }

    /// One episode; the trace of the first is recorded.
    fn run(&self, index: usize, patience: &Patience) -> Result<Measured, EvaluationError> {
        let condition = self.condition(index);
        let mut environment = self.environment(index, &condition)?;
        let stream = self.protocol.stream(index);
        environment.begin(&stream);
        let mut meter = self.meter(index, &condition, &environment);
        let sizes = environment.view().sizes();
        let (mut observation, mut action) = (vec![0.0; sizes.observation], vec![0.0; sizes.action]);
        let mut exploration = self.protocol.explore.then(|| Stream::new(&format!("{stream}/exploration")));
        let deviations = self.subject.blueprint.deviations();
        let (policy, mut scratch) = (Inference::new(self.subject.network), Scratch::default());
        let (start, limit) = (Instant::now(), self.time_limit());
        let mut steps = 0_u64;
        loop {
            if steps.is_multiple_of(LOOK) {
                let simulated_s = steps as f64 / self.subject.blueprint.control_rate();
                patience.look(
                    index,
                    Lasting { wall_s: start.elapsed().as_secs_f64(), simulated_s, limit_s: limit },
                )?;
            }
            environment.view().observe(&mut observation);
            policy.forward(&observation, &mut action, &mut scratch);
            if let Some(stream) = &mut exploration {
                action
                    .iter_mut()
                    .zip(&deviations)
                    .for_each(|(value, std)| *value += (std * stream.normal()) as f32);
            }
            let step = environment.step(&action);
            steps += 1;
            meter.add(&environment.signals(), environment.view().term_values());
            let end = match step.end {
                None => continue,
                Some(End::TimeOut) => "time_out",
                Some(End::Exploded) => EXPLODED,
                Some(End::Terminated(cause)) => &environment.view().causes()[cause],
            };
            let (episode, trace) = meter.finish(&stream, end, step.end == Some(End::TimeOut));
            let command = condition.command.filter(|_| self.command.is_none());
            return Ok((Episode { command, parameters: condition.parameters, ..episode }, trace));
        }
    }

    /// The longest simulated time of an episode in s.
    fn time_limit(&self) -> f64 {
        self.protocol.time_limit.unwrap_or(self.subject.blueprint.episode())
    }

    fn meter(&self, index: usize, condition: &Condition, environment: &RobotEnvironment) -> Meter {
        let blueprint = self.subject.blueprint;
        let limit = self.time_limit();
        let trace = (index == 0).then_some(self.joints.as_slice());
        let meter = Meter::new(&environment.signals(), environment.view().terms(), limit, trace)
            .beyond(self.obstacle.map(|[_, far]| far))
            .with_ankles(self.ankles.clone());
        // With other leg lengths, the soles are elsewhere.
        let nominal = condition.randomized == Randomized::Nothing;
        if trace.is_some() && nominal { meter.with_soles(Kinematics::new(&blueprint.robot)) } else { meter }
    }
}
