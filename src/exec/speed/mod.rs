//! How fast a spec runs on this machine: physics alone, a rollout, the learner, and the whole training.
//!
//! Compare CPU times: on a shared machine, wall time depends on the load.

mod metered;
mod scaling;
mod steps;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use serde::Serialize;

use self::metered::Metered;
pub use self::scaling::{Parts, Row, Scaling};
use crate::bounded;
use crate::env::{Blueprint, BlueprintError, Crew, Mode, RobotCrew, Scene};
use crate::kinds::motion::Frame;
use crate::learn::bench::Rollouts;
use crate::learn::clock::{thread_seconds, timed};
use crate::learn::lane::NotANumber;
use crate::learn::{LearnError, Settings, Start, Training, UpdateMetrics, Watch, train};
use crate::robot::SelfCollision;
use crate::sim::{self, Engine};

/// Number of timed updates, after one for warm-up.
const UPDATES: u64 = 3;

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// CPU time in microseconds of one physics step of the standing robot: setting torques, step, reading
    /// state and contacts. Per robot, if the engine advances several together.
    pub physics_us_per_step: f64,
    /// The same for the engine's step alone, as in a program that calls the engine directly.
    pub engine_us_per_step: f64,
    /// The engine's step alone while position control moves the robot along its reference motion.
    pub moving_us_per_step: f64,
    /// Worlds that the engine advances together.
    pub lanes: usize,
    /// Where the CPU time of a rollout goes, in microseconds per sample.
    pub rollout: RolloutShares,
    /// Control steps per second of wall time while collecting, on all threads.
    pub rollout_samples_per_s: f64,
    /// The same relative to one thread.
    pub rollout_scaling: f64,
    /// CPU time of the learner per sample in microseconds, for both networks and all epochs.
    pub learner_us_per_sample: f64,
    /// Samples per second of wall time for the whole training.
    pub samples_per_s: f64,
    /// Where the time of an iteration goes, and how it scales with threads.
    pub scaling: Scaling,
    /// CPU time per sample in microseconds for the whole training, over all threads.
    pub cpu_us_per_sample: f64,
    /// Largest resident memory of the process in MB.
    pub peak_memory_mb: f64,
    /// Number of threads.
    pub threads: usize,
    /// Name of the engine.
    pub engine: String,
    /// Name of the robot.
    pub robot: String,
    /// The settings that the figures depend on.
    pub settings: Conditions,
}

/// CPU microseconds per sample of a rollout on one thread.
#[derive(Clone, Debug, Serialize)]
pub struct RolloutShares {
    /// All steps of the environments under the policy.
    pub total: f64,
    /// Physics steps.
    pub step: f64,
    /// Reading states and contacts out of the engine.
    pub look: f64,
    /// Building the worlds of new episodes.
    pub build: f64,
    /// The policy, observations, rewards, the controller and records.
    pub rest: f64,
    /// Actor inference, part of `rest`.
    pub policy: f64,
    /// Self-collision check, part of `rest`; zero if the spec does not request it.
    pub self_collision: f64,
    /// Critic values and advantages, computed after the steps and not part of `total`.
    pub values: f64,
    /// Share of the engine: `step`, `look` and `build`.
    pub physics_share: f64,
}

/// The settings that the figures depend on.
#[derive(Clone, Debug, Serialize)]
pub struct Conditions {
    /// Physics rate in Hz.
    pub physics_rate: f64,
    /// Control rate in Hz.
    pub control_rate: f64,
    /// Number of parallel environments.
    pub environments: usize,
    /// Samples per update.
    pub rollout: usize,
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Passes over a rollout.
    pub epochs: usize,
}

/// Why the speed could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum SpeedError {
    /// The environment cannot be built.
    #[error(transparent)]
    Blueprint(#[from] BlueprintError),
    /// The engine cannot be used.
    #[error(transparent)]
    Engine(#[from] sim::EngineError),
    /// The learner failed.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// The folder of a training cannot be created.
    #[error("{path}: {source}")]
    Scratch {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A gradient was NaN or infinite.
    #[error("a gradient is not a number: the learning rate or the rewards are too large")]
    Gradient,
    /// A reward was NaN or infinite.
    #[error("environment {} had a reward that is not a number in step {} of episode \
        {}", .0.environment, .0.step, .0.episode)]
    Reward(NotANumber),
}

impl From<NotANumber> for SpeedError {
    fn from(fault: NotANumber) -> Self {
        Self::Reward(fault)
    }
}

/// Measures a training of this blueprint in this engine for a few updates. `scratch` is an empty folder.
pub fn measure(
    blueprint: &Blueprint,
    engine: Arc<dyn Engine>,
    mut settings: Settings,
    scratch: &Path,
    threads: usize,
) -> Result<Speed, SpeedError> {
    let steps = steps::measure(blueprint, &engine)?;
    settings.samples = (1 + UPDATES) * settings.batch() as u64;
    // Time updates without warm-up from pre-training, in which both networks learn in all epochs.
    settings.warm_up = 0;
    let rollout = shares(blueprint, engine.clone(), &settings)?;
    let turns = scaling::turns(blueprint, &engine, &settings, threads)?;
    let alone = training(blueprint, &engine, &settings, scratch, "one", 1)?;
    let together = match threads {
        1 => alone.clone(),
        _ => training(blueprint, &engine, &settings, scratch, "all", threads)?,
    };
    let (rollout_samples_per_s, rollout_scaling) = turns.rollouts(settings.batch());
    let scaling = turns.scaling(settings.batch(), &alone, &together, threads);
    let (seen, samples) = (&together.seen, together.samples());
    let (first, last) = (&seen[0], &seen[seen.len() - 1]);
    Ok(Speed {
        physics_us_per_step: steps.whole,
        engine_us_per_step: steps.bare,
        moving_us_per_step: steps.moving,
        lanes: engine.width(),
        rollout,
        rollout_samples_per_s,
        rollout_scaling,
        learner_us_per_sample: 1e6 * seen[1..].iter().map(|update| update.learner_cpu_s).sum::<f64>()
            / samples,
        samples_per_s: together.samples_per_s(),
        scaling,
        cpu_us_per_sample: 1e6 * (last.cpu_s - first.cpu_s) / samples,
        peak_memory_mb: peak_memory(),
        threads,
        engine: blueprint.engine().to_owned(),
        robot: blueprint.robot.name.clone(),
        settings: Conditions {
            physics_rate: blueprint.physics_rate(),
            control_rate: blueprint.control_rate(),
            environments: settings.environments,
            rollout: settings.batch(),
            minibatch: settings.minibatch,
            epochs: settings.epochs,
        },
    })
}

/// The environments of a training on this many threads.
fn crews(
    blueprint: &Blueprint,
    engine: Arc<dyn Engine>,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Box<dyn Crew>>, BlueprintError> {
    let scene = blueprint.scene(engine, &Mode::Training)?;
    Ok(RobotCrew::divided(&scene, settings.environments, threads))
}

/// Where the CPU time of a rollout goes, on one thread: the total from unmodified rollouts, the shares from
/// the same rollouts with all engine calls timed.
fn shares(
    blueprint: &Blueprint,
    engine: Arc<dyn Engine>,
    settings: &Settings,
) -> Result<RolloutShares, SpeedError> {
    let (metered, spent) = Metered::new(engine.clone());
    let plain_scene = blueprint.scene(engine.clone(), &Mode::Training)?;
    let mut plain = Rollouts::new(crews(blueprint, engine, settings, 1)?, settings)?;
    let mut timed = Rollouts::new(crews(blueprint, Arc::new(metered), settings, 1)?, settings)?;
    let (mut totals, mut values, mut parts) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
    for update in 0..=UPDATES {
        let cpu = plain.collect(1)?.cpu;
        let before = spent.seconds();
        let collected = timed.collect(1)?;
        let after = spent.seconds();
        if update > 0 {
            let us = |seconds: f64| 1e6 * seconds / settings.batch() as f64;
            totals.push(us(cpu.all - cpu.values));
            values.push(us(cpu.values));
            let wall = collected.wall - collected.cpu.values - (after.timing - before.timing);
            let spent = [after.step - before.step, after.look - before.look, after.build - before.build];
            parts.iter_mut().zip(spent).for_each(|(parts, spent)| parts.push(spent / wall));
        }
    }
    let (total, values) = (median(totals), median(values));
    let [step, look, build] = parts.map(|shares| total * median(shares));
    let physics = step + look + build;
    let policy = 1e6 * plain.inference();
    let self_collision = 1e6 * self_collision(blueprint, &plain_scene);
    let (rest, physics_share) = (total - physics, physics / total);
    Ok(RolloutShares { total, step, look, build, rest, policy, self_collision, values, physics_share })
}

/// CPU time in s of one self-collision check, over poses of the reference; zero if the scene has none.
fn self_collision(blueprint: &Blueprint, scene: &Scene) -> f64 {
    const POSES: usize = 720;
    let Some(pairs) = scene.guarded() else { return 0.0 };
    let mut check = SelfCollision::new(&blueprint.robot, pairs.to_vec());
    let mut frame = Frame::default();
    let mut pose = |index| {
        scene.motion().state_at(index as f64 / POSES as f64, &mut frame);
        frame.position.clone()
    };
    let poses: Vec<Vec<f64>> = (0..POSES).map(&mut pose).collect();
    let mut round =
        |_| timed(|| poses.iter().filter(|pose| check.find(pose).is_some()).count()).1 / POSES as f64;
    median((0..9).map(&mut round).collect())
}

/// A training of a few updates on this many threads, in a new folder of that name.
fn training(
    blueprint: &Blueprint,
    engine: &Arc<dyn Engine>,
    settings: &Settings,
    scratch: &Path,
    name: &str,
    threads: usize,
) -> Result<Seen, SpeedError> {
    let scratch = scratch.join(name);
    std::fs::create_dir_all(&scratch)
        .map_err(|source| SpeedError::Scratch { path: scratch.clone(), source })?;
    let observer = Observer::default();
    let (start, scratch) = (Start::default(), scratch.as_path());
    let training = Training { settings, start, scratch, threads: &|| threads, watch: &observer };
    train(training, crews(blueprint, engine.clone(), settings, threads)?)?;
    let (seen, clock) = observer.seen.into_inner().expect("nobody panics while watching").into_iter().unzip();
    Ok(Seen { seen, clock })
}

/// The updates of a training; the first is for warm-up.
#[derive(Clone)]
struct Seen {
    seen: Vec<UpdateMetrics>,
    /// CPU time in s of the training's own thread after each update.
    clock: Vec<f64>,
}

impl Seen {
    fn samples(&self) -> f64 {
        (self.seen[self.seen.len() - 1].samples - self.seen[0].samples) as f64
    }

    /// Samples per second of wall time.
    fn samples_per_s(&self) -> f64 {
        self.samples() / (self.seen[self.seen.len() - 1].wall_s - self.seen[0].wall_s)
    }
}

/// The median.
fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// Peak resident memory of this process in MB, as reported by the kernel; 0 if unavailable.
fn peak_memory() -> f64 {
    let status = bounded::text(Path::new("/proc/self/status"), bounded::WRITTEN).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace()
        .next()
        .and_then(|number| number.parse::<f64>().ok())
        .map_or(0.0, |kib| kib / 1024.0)
}

/// Records the metrics and this thread's CPU time at each update.
#[derive(Default)]
struct Observer {
    seen: Mutex<Vec<(UpdateMetrics, f64)>>,
}

impl Watch for Observer {
    fn update(&self, metrics: &UpdateMetrics) {
        self.seen.lock().expect("nobody panics while watching").push((metrics.clone(), thread_seconds()));
    }

    fn interrupted(&self) -> bool {
        false
    }
}
