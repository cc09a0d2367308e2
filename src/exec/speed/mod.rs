//! How fast a spec runs on this machine: physics alone, a rollout, the learner, and all together.
//!
//! CPU time is the figure to compare: wall time on a shared machine is what the others leave.

mod metered;
mod scaling;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use serde::Serialize;

use self::metered::Metered;
pub use self::scaling::{Parts, Row, Scaling};
use crate::bounded;
use crate::env::{Blueprint, BlueprintError, Crew, Mode, RobotCrew};
use crate::learn::bench::Rollouts;
use crate::learn::clock::{thread_seconds, timed};
use crate::learn::lane::NotANumber;
use crate::learn::{LearnError, Settings, Start, Training, UpdateMetrics, Watch, train};
use crate::sim::{self, Engine, EngineSettings, State, Terrain, World};

/// Physics steps that are timed at a stretch.
const STEPS: usize = 1000;
/// Stretches of the whole step and of the engine's own, in turn.
const STRETCHES: usize = 9;
/// Updates that are timed, after one that warms up.
const UPDATES: u64 = 3;

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// CPU time of one physics step of the standing robot in microseconds: torques handed over, step, state and
    /// contacts read.
    pub physics_us_per_step: f64,
    /// The same of the engine's own step alone, as a program pays that calls the engine directly.
    pub engine_us_per_step: f64,
    /// Where the CPU time of a rollout goes, in microseconds per sample.
    pub rollout: RolloutShares,
    /// Control steps per second of wall time while collecting, on all threads.
    pub rollout_samples_per_s: f64,
    /// The same over that on one thread.
    pub rollout_scaling: f64,
    /// CPU time of the learner per sample in microseconds, both networks and all passes.
    pub learner_us_per_sample: f64,
    /// Samples per second of wall time, all together.
    pub samples_per_s: f64,
    /// What more threads would bring.
    pub scaling: Scaling,
    /// CPU time per sample in microseconds, all together, over all threads.
    pub cpu_us_per_sample: f64,
    /// Largest resident memory of the process in MB.
    pub peak_memory_mb: f64,
    /// Threads.
    pub threads: usize,
    /// The engine.
    pub engine: String,
    /// The robot.
    pub robot: String,
    /// What the figures depend on.
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
    /// What comes after the steps and is not in the total: the critic's values and the advantages.
    pub values: f64,
    /// Share of the engine: steps, looks and builds.
    pub physics_share: f64,
}

/// What the figures depend on.
#[derive(Clone, Debug, Serialize)]
pub struct Conditions {
    /// Physics rate in Hz.
    pub physics_rate: f64,
    /// Control rate in Hz.
    pub control_rate: f64,
    /// Environments side by side.
    pub environments: usize,
    /// Samples per update.
    pub rollout: usize,
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Passes over a rollout.
    pub epochs: usize,
}

/// Why nothing was measured.
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
    /// The folder of a training cannot be made.
    #[error("{path}: {source}")]
    Scratch {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A gradient was no number.
    #[error("a gradient is not a number: the learning rate or the rewards are too large")]
    Gradient,
    /// A reward was no number.
    #[error("environment {} had a reward that is no number in step {} of episode {}", .0.environment, .0.step, .0.episode)]
    Reward(NotANumber),
}

impl From<NotANumber> for SpeedError {
    fn from(fault: NotANumber) -> Self {
        Self::Reward(fault)
    }
}

/// Measures a training of this blueprint for a few updates. `scratch` is an empty folder.
pub fn measure(
    blueprint: &Blueprint,
    mut settings: Settings,
    scratch: &Path,
    threads: usize,
) -> Result<Speed, SpeedError> {
    let (physics, bare) = physics(blueprint)?;
    let engine = sim::open(blueprint.engine())?;
    settings.samples = (1 + UPDATES) * settings.batch() as u64;
    // An update without a pre-trained actor, with both networks learning in all passes.
    settings.warm_up = 0;
    let rollout = shares(blueprint, engine.clone(), &settings)?;
    let turns = scaling::turns(blueprint, &engine, &settings, threads)?;
    let alone = training(blueprint, &engine, &settings, (scratch, "one", 1))?;
    let together = match threads {
        1 => alone.clone(),
        _ => training(blueprint, &engine, &settings, (scratch, "all", threads))?,
    };
    let (rollout_samples_per_s, rollout_scaling) = turns.rollouts(settings.batch());
    let scaling = turns.scaling((settings.batch(), settings.environments), [&alone, &together], threads);
    let (seen, samples) = (&together.seen, together.samples());
    let (first, last) = (&seen[0], &seen[seen.len() - 1]);
    Ok(Speed {
        physics_us_per_step: physics,
        engine_us_per_step: bare,
        rollout,
        rollout_samples_per_s,
        rollout_scaling,
        learner_us_per_sample: 1e6 * seen[1..].iter().map(|update| update.learner_cpu_s).sum::<f64>() / samples,
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

/// The environments of a training on so many threads.
fn crews(
    blueprint: &Blueprint,
    engine: Arc<dyn Engine>,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Box<dyn Crew>>, BlueprintError> {
    let scene = blueprint.scene(engine, &Mode::Training)?;
    Ok(RobotCrew::divided(&scene, settings.environments, threads))
}

/// Where the CPU time of a rollout goes, on one thread: all of it from rollouts as they are, the shares from the same
/// rollouts with every call of the engine timed.
fn shares(blueprint: &Blueprint, engine: Arc<dyn Engine>, settings: &Settings) -> Result<RolloutShares, SpeedError> {
    let (metered, spent) = Metered::new(engine.clone());
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
    Ok(RolloutShares { total, step, look, build, rest: total - physics, values, physics_share: physics / total })
}

/// A training of a few updates on so many threads, in a new folder of that name.
fn training(
    blueprint: &Blueprint,
    engine: &Arc<dyn Engine>,
    settings: &Settings,
    (scratch, name, threads): (&Path, &str, usize),
) -> Result<Seen, SpeedError> {
    let scratch = scratch.join(name);
    std::fs::create_dir_all(&scratch).map_err(|source| SpeedError::Scratch { path: scratch.clone(), source })?;
    let observer = Observer::default();
    let (start, scratch) = (Start::default(), scratch.as_path());
    let training = Training { settings, start, scratch, threads: &|| threads, watch: &observer };
    train(training, crews(blueprint, engine.clone(), settings, threads)?)?;
    let (seen, clock) = observer.seen.into_inner().expect("nobody panics while watching").into_iter().unzip();
    Ok(Seen { seen, clock })
}

/// The updates of a training; the first warms up.
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

    /// Per second of wall time.
    fn samples_per_s(&self) -> f64 {
        self.samples() / (self.seen[self.seen.len() - 1].wall_s - self.seen[0].wall_s)
    }
}

/// CPU microseconds per step of the robot held in its default pose: as an environment steps, and of the engine alone.
fn physics(blueprint: &Blueprint) -> Result<(f64, f64), SpeedError> {
    let mut stand = Stand::new(blueprint)?;
    stand.hold(STEPS);
    let (mut whole, mut bare) = (Vec::new(), Vec::new());
    for _ in 0..STRETCHES {
        let mut inside = 0.0;
        let ((), cpu) = timed(|| stand.hold(STEPS));
        whole.push(cpu);
        for _ in 0..STEPS {
            stand.balance();
            stand.world.apply(&stand.torque);
            inside += timed(|| stand.world.advance()).1;
            stand.world.read(&mut stand.state);
        }
        let ((), clock) = timed(|| (0..STEPS).for_each(|_| _ = std::hint::black_box(timed(|| ()))));
        bare.push(inside - clock / 2.0);
    }
    let us = |seconds: Vec<f64>| 1e6 * median(seconds) / STEPS as f64;
    Ok((us(whole), us(bare)))
}

/// The robot that is held in its default pose by its own gains.
struct Stand<'a> {
    robot: &'a crate::robot::Robot,
    world: Box<dyn World>,
    pose: Vec<f64>,
    state: State,
    torque: Vec<f64>,
}

impl<'a> Stand<'a> {
    fn new(blueprint: &'a Blueprint) -> Result<Self, SpeedError> {
        let robot = &blueprint.robot;
        let state = State {
            base_position: [0.0, 0.0, robot.standing_height],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            position: robot.default_pose(),
            velocity: vec![0.0; robot.joints()],
            ..State::default()
        };
        let settings = EngineSettings { step: 1.0 / blueprint.physics_rate(), friction: 1.0, contact_time: None };
        let world = sim::open(blueprint.engine())?.build(robot, &Terrain::Flat, &settings, &state)?;
        Ok(Self { robot, world, pose: robot.default_pose(), state, torque: vec![0.0; robot.joints()] })
    }

    /// The torques that hold the pose.
    fn balance(&mut self) {
        for (index, link) in self.robot.links.iter().enumerate() {
            let joint = &link.joint;
            let pull = joint.stiffness_gain * (self.pose[index] - self.state.position[index]);
            let push = pull - joint.damping_gain * self.state.velocity[index];
            self.torque[index] = push.clamp(-joint.effort_limit, joint.effort_limit);
        }
    }

    /// Physics steps as an environment makes them.
    fn hold(&mut self, steps: usize) {
        for _ in 0..steps {
            self.balance();
            self.world.step(&self.torque);
            std::hint::black_box(self.world.is_sane());
            self.world.read(&mut self.state);
            std::hint::black_box(self.world.contacts());
        }
    }
}

/// The middle of some figures.
fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// Largest resident memory of this process in MB, from the kernel's own account; 0 where there is none.
fn peak_memory() -> f64 {
    let status = bounded::text(Path::new("/proc/self/status"), bounded::WRITTEN).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|number| number.parse::<f64>().ok()).map_or(0.0, |kib| kib / 1024.0)
}

/// Keeps the metrics, and what this thread has spent until then.
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
