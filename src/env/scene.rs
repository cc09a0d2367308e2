//! A blueprint compiled for one engine, shared by all environments of a training or an evaluation.

use std::sync::Arc;

use super::blueprint::{Blueprint, BlueprintError};
use super::command::CommandPlan;
use super::ground;
use super::interface::{Output, Sizes};
use super::observation::Observation;
use super::privileged::Privileged;
use super::start::StartPlan;
use super::trial::{Mode, Randomized, Trial};
use crate::control::{Law, LowPass};
use crate::kinds::motion::Motion;
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_position::JointPosition;
use crate::kinds::observe::joint_velocity::JointVelocity;
use crate::kinds::randomize::Randomization;
use crate::kinds::terminate::contact_schedule::ContactSchedule;
use crate::kinds::terminate::joint_error::JointError;
use crate::kinds::terrain::Ground;
use crate::kinds::{Reward, Termination, randomize, reward, terminate};
use crate::robot::self_collision::{Pair, SelfCollision};
use crate::robot::{GRAVITY, Robot};
use crate::sim::{Engine, EngineError, EngineSettings, State, Terrain};
use crate::spec::section::RewardTerm;
use crate::spec::typed::{Declared, InSection};
use crate::spec::{Sampler, Section, Signal};

/// A compiled environment.
pub struct Scene {
    pub(super) engine: Arc<dyn Engine>,
    pub(super) settings: EngineSettings,
    pub(super) terrain: Terrain,
    pub(super) robot: Robot,
    pub(super) motion: Motion,
    pub(super) observation: Observation,
    pub(super) privileged: Privileged,
    pub(super) sizes: Sizes,
    pub(super) law: Law,
    pub(super) rates: Rates,
    pub(super) averaging: LowPass,
    pub(super) encoder: (Option<Sampler>, LowPass),
    pub(super) start: StartPlan,
    pub(super) command: CommandPlan,
    pub(super) rewards: Vec<(f64, Box<dyn Reward>)>,
    pub(super) reward_names: Vec<String>,
    pub(super) reward_ranges: Vec<[f64; 2]>,
    pub(super) outputs: Vec<Output>,
    pub(super) terminations: Vec<Box<dyn Termination>>,
    pub(super) causes: Vec<String>,
    pub(super) schedule: Option<usize>,
    /// Pairs of bodies checked for self-collision, if a term or an evaluation uses them.
    pub(super) guarded: Option<Vec<Pair>>,
    pub(super) randomizations: Vec<(String, Box<dyn Randomization>)>,
}

/// Periods of an environment, in physics steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rates {
    /// Physics steps per control step.
    pub control: usize,
    /// Physics steps per servo step.
    pub servo: usize,
    /// Nominal action delay in physics steps, which may be fractional.
    pub delay: f64,
    /// Duration of a control step in s.
    pub step: f64,
    /// Control steps of an episode.
    pub limit: u64,
    /// Relative increase of the phase's speed when the last action is 1; `None` if the last action moves a
    /// joint.
    pub modulation: Option<f64>,
}

impl Blueprint {
    /// Compiles the environment for an engine; environments of one scene share everything that does not
    /// change.
    pub fn scene(&self, engine: Arc<dyn Engine>, mode: &Mode) -> Result<Arc<Scene>, BlueprintError> {
        self.check()?;
        let scene = Scene::new(self, engine, mode)?;
        scene.accepted()?;
        Ok(Arc::new(scene))
    }
}

impl Scene {
    /// Compiles a checked blueprint.
    pub(super) fn new(
        blueprint: &Blueprint,
        engine: Arc<dyn Engine>,
        mode: &Mode,
    ) -> Result<Self, BlueprintError> {
        let ground: Ground = blueprint.part();
        let trial = match mode {
            Mode::Training => None,
            Mode::Evaluation(trial) => Some(trial),
        };
        let physics_step = 1.0 / blueprint.physics_rate();
        let settings = EngineSettings {
            step: physics_step,
            friction: ground.friction(),
            contact_time: trial.and_then(|trial| trial.contact_time),
        };
        let robot = blueprint.robot.clone();
        let privileged = Privileged { height: robot.standing_height, weight: robot.total_mass() * GRAVITY };
        let (rewards, reward_names) = rewards(blueprint.section(reward::Rewards::SECTION));
        let (terminations, causes, schedule) = terminations(blueprint, trial.is_none());
        Ok(Self {
            engine,
            settings,
            terrain: ground::terrain(&ground),
            motion: blueprint.reference().into_owned(),
            observation: blueprint.observation(),
            privileged,
            sizes: blueprint.sizes(),
            law: blueprint.law(),
            rates: rates(blueprint, trial),
            averaging: averaging(blueprint),
            encoder: encoder(blueprint, trial.is_none_or(|trial| trial.noise), physics_step),
            start: match trial {
                None => StartPlan::new(&blueprint.part()),
                Some(trial) => StartPlan::standing(vec![trial.phase], trial.perturbation),
            },
            command: match trial.and_then(|trial| trial.command) {
                None => CommandPlan::new(&blueprint.part()),
                Some(speed) => CommandPlan::constant(speed),
            },
            // A term is its weight times a number in [0, 1].
            reward_ranges: rewards.iter().map(|(weight, _)| [weight.min(0.0), weight.max(0.0)]).collect(),
            outputs: outputs(blueprint),
            rewards,
            reward_names,
            terminations,
            causes,
            schedule,
            guarded: (trial.is_some() || looks_at(blueprint, Signal::SelfCollision))
                .then(|| SelfCollision::pairs(&robot)),
            randomizations: match trial.map(|trial| &trial.randomized) {
                None | Some(Randomized::AsTrained) => {
                    table(Section::new(&blueprint.fields).within::<randomize::Rows>())
                }
                Some(Randomized::Nothing) => Vec::new(),
                Some(Randomized::By(rows)) => table(Some(Section::new(rows))),
            },
            robot,
        })
    }

    /// Fails if the engine refuses the nominal robot on this ground. An episode whose robot is refused ends
    /// as if its physics had diverged, so the reason would be lost.
    fn accepted(&self) -> Result<(), EngineError> {
        self.engine.build(&self.robot, &self.terrain, &self.settings, &State::of(&self.robot)).map(drop)
    }

    /// Duration of a control step in s.
    pub fn step(&self) -> f64 {
        self.rates.step
    }

    /// The nominal robot.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Pairs of bodies checked for self-collision, if anything uses them.
    pub fn guarded(&self) -> Option<&[Pair]> {
        self.guarded.as_deref()
    }

    /// The reference motion.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }
}

/// The terms of a section, each with its name and its kind's name.
fn terms(section: Section<'_>) -> impl Iterator<Item = (&str, &str, Section<'_>)> {
    section.sections().map(|(name, term)| (name, term.kind().unwrap_or(name), term))
}

/// Weighted terms and their names.
pub(super) type Rewards = (Vec<(f64, Box<dyn Reward>)>, Vec<String>);

/// The terms of `[reward]`.
pub(super) fn rewards(section: Section) -> Rewards {
    let mut rewards = Vec::new();
    let mut names = Vec::new();
    for (name, kind, term) in terms(section) {
        if let Some(entry) = reward::KINDS.iter().find(|entry| entry.kind.name == kind) {
            rewards.push((
                term.value(RewardTerm::weight).expect("a reward term has a weight"),
                (entry.build)(term),
            ));
            names.push(name.to_owned());
        }
    }
    (rewards, names)
}

/// The outputs of the actor: those of the control law, and the phase's speed if the spec has a phase action.
fn outputs(blueprint: &Blueprint) -> Vec<Output> {
    let (law, names) = (blueprint.law(), blueprint.robot.links.iter().map(|link| &link.joint.name));
    let joints =
        names.zip(law.ranges()).map(|(name, range)| Output { name: name.clone(), range, optional: false });
    let phase = Output { name: "phase".into(), range: [0.0, 1.0], optional: true };
    joints.chain(blueprint.modulates_phase().then_some(phase)).collect()
}

type Terminations = (Vec<Box<dyn Termination>>, Vec<String>, Option<usize>);

/// The terminations, their names and the index of the contact schedule's.
fn terminations(blueprint: &Blueprint, training: bool) -> Terminations {
    let (mut built, mut names, mut schedule) = (Vec::new(), Vec::new(), None);
    let section = Section::new(&blueprint.fields).within::<terminate::Terminations>();
    for (name, kind, term) in section.into_iter().flat_map(terms) {
        let is_schedule = kind == ContactSchedule::KIND.name;
        let guard = is_schedule || kind == JointError::KIND.name;
        let entry = terminate::KINDS.iter().find(|entry| entry.kind.name == kind);
        if let Some(entry) = entry.filter(|_| training || !guard) {
            if is_schedule {
                schedule = Some(built.len());
            }
            built.push((entry.build)(term));
            names.push(name.to_owned());
        }
    }
    (built, names, schedule)
}

/// Whether a termination uses this signal.
fn looks_at(blueprint: &Blueprint, signal: Signal) -> bool {
    let section = Section::new(&blueprint.fields).within::<terminate::Terminations>();
    let kinds = section.into_iter().flat_map(terms).map(|(_, kind, _)| kind);
    let needs = |word: &str| {
        terminate::KINDS.iter().any(|entry| entry.kind.name == word && entry.kind.needs.contains(&signal))
    };
    kinds.into_iter().any(needs)
}

/// The rows of a table `[randomize]`, in the order in which they are applied.
fn table(section: Option<Section>) -> Vec<(String, Box<dyn Randomization>)> {
    let mut rows = Vec::new();
    for entry in randomize::KINDS {
        for (name, _, term) in
            section.into_iter().flat_map(terms).filter(|(_, kind, _)| *kind == entry.kind.name)
        {
            rows.push((name.to_owned(), (entry.build)(term)));
        }
    }
    rows
}

fn rates(blueprint: &Blueprint, trial: Option<&Trial>) -> Rates {
    let (physics, control) = (blueprint.physics_rate(), blueprint.control_rate());
    let servo = blueprint.law().servo_rate();
    let limit = trial.and_then(|trial| trial.time_limit).unwrap_or(blueprint.episode());
    let ratio = |rate: f64| (physics / rate).round() as usize;
    Rates {
        control: ratio(control),
        servo: servo.map_or(ratio(control), ratio),
        delay: blueprint.action().delay() * physics,
        step: 1.0 / control,
        limit: (limit * control).round().max(1.0) as u64,
        modulation: blueprint.phase_gain(),
    }
}

/// The low-pass filter that removes the oscillation within a step from a velocity: its time constant is half
/// a cycle of the motion.
fn averaging(blueprint: &Blueprint) -> LowPass {
    let time = 0.5 * blueprint.reference().period;
    LowPass::new(1.0 / (std::f64::consts::TAU * time), 1.0 / blueprint.control_rate())
}

/// Encoder noise and velocity filter.
fn encoder(blueprint: &Blueprint, noisy: bool, step: f64) -> (Option<Sampler>, LowPass) {
    let (mut noise, mut filter) = (None, LowPass::open());
    for (_, kind, term) in terms(blueprint.section(Observations::SECTION)) {
        if kind == JointPosition::KIND.name {
            noise = term.value(JointPosition::noise).filter(|_| noisy);
        } else if kind == JointVelocity::KIND.name {
            let cutoff = term.value(JointVelocity::low_pass);
            filter = cutoff.map_or(LowPass::open(), |cutoff| LowPass::new(cutoff, step));
        }
    }
    (noise, filter)
}
