//! How fast a spec runs on this machine: physics alone, a rollout, the learner, and all together.
//!
//! CPU time is the figure to compare: wall time on a shared machine is what the others leave.

use std::path::Path;
use std::sync::Mutex;

use serde::Serialize;

use crate::env::{Blueprint, BlueprintError, Environment, Mode, RobotEnvironment};
use crate::learn::clock::timed;
use crate::learn::{LearnError, Settings, Training, UpdateMetrics, Watch, train};
use crate::sim::{self, EngineSettings, State, Terrain};

/// Physics steps that are timed.
const STEPS: usize = 4000;
/// Updates that are timed, after one that warms up.
const UPDATES: u64 = 3;

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// CPU time of one physics step of the standing robot, reading its state included, in microseconds.
    pub physics_us_per_step: f64,
    /// Control steps per second of wall time while collecting.
    pub rollout_samples_per_s: f64,
    /// CPU time of the learner per sample in microseconds, both networks and all passes.
    pub learner_us_per_sample: f64,
    /// Samples per second of wall time, all together.
    pub samples_per_s: f64,
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
}

/// Measures a training of this blueprint for a few updates. `scratch` is an empty folder.
pub fn measure(
    blueprint: &Blueprint,
    mut settings: Settings,
    scratch: &Path,
    threads: usize,
) -> Result<Speed, SpeedError> {
    let physics = physics(blueprint)?;
    settings.samples = (1 + UPDATES) * settings.batch() as u64;
    // An update without a pre-trained actor, with both networks learning in all passes.
    settings.warm_up = 0;
    let engine = sim::open(blueprint.engine())?;
    let scene = blueprint.scene(engine, &Mode::Training)?;
    let environments =
        (0..settings.environments).map(|_| Box::new(RobotEnvironment::new(scene.clone())) as Box<dyn Environment>);
    let observer = Observer::default();
    let training = Training { settings: &settings, init: None, scratch, threads: &|| threads, watch: &observer };
    train(training, environments.collect())?;
    let seen = observer.seen.into_inner().expect("nobody panics while watching");
    let (first, last) = (&seen[0], &seen[seen.len() - 1]);
    let samples = (last.samples - first.samples) as f64;
    let cpu_us_per_sample = 1e6 * (last.cpu_s - first.cpu_s) / samples;
    let learner = 1e6 * seen[1..].iter().map(|update| update.learner_cpu_s).sum::<f64>() / samples;
    let samples_per_s = samples / (last.wall_s - first.wall_s);
    let share = 1.0 - (learner / cpu_us_per_sample).min(0.99);
    Ok(Speed {
        physics_us_per_step: physics,
        rollout_samples_per_s: samples_per_s / share,
        learner_us_per_sample: learner,
        samples_per_s,
        cpu_us_per_sample,
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

/// CPU microseconds per step of the robot held in its default pose.
fn physics(blueprint: &Blueprint) -> Result<f64, SpeedError> {
    let robot = &blueprint.robot;
    let start = State {
        base_position: [0.0, 0.0, robot.standing_height],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        ..State::default()
    };
    let settings = EngineSettings { step: 1.0 / blueprint.physics_rate(), friction: 1.0, contact_time: None };
    let mut world = sim::open(blueprint.engine())?.build(robot, &Terrain::Flat, &settings, &start)?;
    let (mut state, mut torque) = (start.clone(), vec![0.0; robot.joints()]);
    let mut hold = |steps: usize| {
        for _ in 0..steps {
            for (index, link) in robot.links.iter().enumerate() {
                let joint = &link.joint;
                let pull = joint.stiffness_gain * (start.position[index] - state.position[index]);
                let push = pull - joint.damping_gain * state.velocity[index];
                torque[index] = push.clamp(-joint.effort_limit, joint.effort_limit);
            }
            world.step(&torque);
            world.read(&mut state);
        }
    };
    hold(STEPS / 10);
    let ((), cpu) = timed(|| hold(STEPS));
    Ok(1e6 * cpu / STEPS as f64)
}

/// Largest resident memory of this process in MB, from the kernel's own account; 0 where there is none.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|number| number.parse::<f64>().ok()).map_or(0.0, |kib| kib / 1024.0)
}

/// Keeps the metrics.
#[derive(Default)]
struct Observer {
    seen: Mutex<Vec<UpdateMetrics>>,
}

impl Watch for Observer {
    fn update(&self, metrics: &UpdateMetrics) {
        self.seen.lock().expect("nobody panics while watching").push(metrics.clone());
    }

    fn interrupted(&self) -> bool {
        false
    }
}
