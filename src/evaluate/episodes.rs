//! The protocol `episodes`: the deterministic policy in a number of independent episodes.
//!
//! Episodes run side by side on threads; each depends on its own stream alone, so the result does not
//! depend on the number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::meter::Meter;
use super::protocol::Protocol;
use crate::env::{Blueprint, BlueprintError, End, Environment, Mode, RobotEnvironment, Scene, Trial};
use crate::learn::inference::{Inference, Scratch};
use crate::learn::network::Network;
use crate::outcome::{Episode, Evaluation, Trace};
use crate::sim::Engine;

/// A policy in its environment, to be evaluated in an engine.
pub struct Subject<'a> {
    /// The actor.
    pub network: &'a Network,
    /// Where it acts.
    pub blueprint: &'a Blueprint,
    /// The engine.
    pub engine: Arc<dyn Engine>,
    /// Time constant of soft contacts in s; `None` is the engine's own.
    pub contact_time: Option<f64>,
}

/// Why an evaluation has no result.
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
        /// Of the environment.
        expected: usize,
        /// Of the network.
        found: usize,
    },
    /// Somebody wanted to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Runs the episodes on up to `threads` threads. `progress` is told the number of finished episodes and
/// says whether to go on.
pub fn episodes(
    subject: &Subject,
    protocol: &Protocol,
    threads: usize,
    progress: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Evaluation, EvaluationError> {
    check(subject)?;
    let command = protocol.command.or_else(|| usual_command(subject.blueprint));
    let starts = subject.blueprint.starts().into_iter().map(|phase| scene(subject, protocol, command, phase));
    let scenes: Vec<Arc<Scene>> = starts.collect::<Result<_, _>>()?;
    let results = in_parallel(protocol.episodes, threads, progress, &|index| {
        run(RobotEnvironment::new(scenes[index % scenes.len()].clone()), subject, protocol, index)
    });
    let mut evaluation = Evaluation {
        engine: subject.engine.name().into(),
        physics_rate: subject.blueprint.physics_rate(),
        control_rate: subject.blueprint.control_rate(),
        command,
        time_limit: protocol.time_limit.unwrap_or(subject.blueprint.episode()),
        ..Evaluation::default()
    };
    for (episode, trace) in results? {
        evaluation.episodes.push(episode);
        evaluation.trace = trace.unwrap_or(evaluation.trace);
    }
    Ok(evaluation)
}

/// Works on the indices below `count` on up to `threads` threads; the results are in order of the index.
fn in_parallel<T: Send>(
    count: usize,
    threads: usize,
    progress: &(dyn Fn(usize) -> bool + Sync),
    work: &(dyn Fn(usize) -> T + Sync),
) -> Result<Vec<T>, EvaluationError> {
    let (next, finished, stopped) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    let share = || {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count || stopped.load(Ordering::Relaxed) {
                return results;
            }
            results.push((index, work(index)));
            if !progress(finished.fetch_add(1, Ordering::Relaxed) + 1) {
                stopped.store(true, Ordering::Relaxed);
            }
        }
    };
    let mut results = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(count)).map(|_| scope.spawn(share)).collect();
        let mut results = share();
        for other in others {
            results.extend(other.join().expect("an episode does not panic"));
        }
        results
    });
    if results.len() < count {
        return Err(EvaluationError::Interrupted);
    }
    results.sort_by_key(|(index, _)| *index);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

/// Refuses a network whose vectors have other lengths than the environment's.
fn check(subject: &Subject) -> Result<(), EvaluationError> {
    let sizes = subject.blueprint.sizes();
    let sides =
        [("inputs", sizes.observation, subject.network.inputs()), ("outputs", sizes.action, subject.network.outputs())];
    match sides.into_iter().find(|(_, expected, found)| expected != found) {
        Some((side, expected, found)) => Err(EvaluationError::Shape { side, expected, found }),
        None => Ok(()),
    }
}

/// The middle of the task's range of speeds in m/s; `None` for a task without a command.
fn usual_command(blueprint: &Blueprint) -> Option<f64> {
    let command = blueprint.section("task").section("command")?;
    let [low, high] = command.sampler_if("speed")?.bounds();
    Some(0.5 * (low + high))
}

fn scene(
    subject: &Subject,
    protocol: &Protocol,
    command: Option<f64>,
    phase: f64,
) -> Result<Arc<Scene>, EvaluationError> {
    let trial = Trial {
        command,
        phase,
        perturbation: protocol.perturbation,
        time_limit: protocol.time_limit,
        noise: protocol.noise,
        randomize: protocol.randomize,
        contact_time: subject.contact_time,
    };
    Ok(subject.blueprint.scene(subject.engine.clone(), &Mode::Evaluation(trial))?)
}

/// One episode; the first keeps its trace.
fn run(
    mut environment: RobotEnvironment,
    subject: &Subject,
    protocol: &Protocol,
    index: usize,
) -> (Episode, Option<Trace>) {
    let stream = protocol.stream(index);
    environment.begin(&stream);
    let joints: Vec<String> = subject.blueprint.robot.links.iter().map(|link| link.joint.name.clone()).collect();
    let limit = protocol.time_limit.unwrap_or(subject.blueprint.episode());
    let trace = (index == 0).then_some(joints.as_slice());
    let mut meter = Meter::new(&environment.signals(), environment.terms(), limit, trace);
    let sizes = environment.sizes();
    let (mut observation, mut action) = (vec![0.0; sizes.observation], vec![0.0; sizes.action]);
    let (policy, mut scratch) = (Inference::new(subject.network), Scratch::default());
    loop {
        environment.observe(&mut observation);
        policy.forward(&observation, &mut action, &mut scratch);
        let step = environment.step(&action);
        meter.add(&environment.signals(), environment.term_values());
        let end = match step.end {
            None => continue,
            Some(End::TimeOut) => "time_out",
            Some(End::Exploded) => "exploded",
            Some(End::Terminated(cause)) => &environment.causes()[cause],
        };
        return meter.finish(&stream, end, step.end == Some(End::TimeOut));
    }
}
