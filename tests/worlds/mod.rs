//! Worlds for measurements: environments made from the committed parents by way of the checker, in any
//! engine, with a start that the test moves and a record of every physics step.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::Path;
use std::sync::{Arc, Mutex};

use nalgebra::{DVector, Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use specforge::check::checked_in;
use specforge::env::{Blueprint, Mode, Randomized, RobotEnvironment, Trial};
use specforge::kinds::motion;
use specforge::kinds::motion::clip::Clip;
use specforge::robot::{Kinematics, Robot};
use specforge::sim::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World, open};
use specforge::spec::{LoadOptions, Section};
use specforge::syntax::{Disk, Overlay};

/// Acceleration of gravity in m/s^2.
pub const GRAVITY: f64 = 9.81;

/// The paper's table of randomization, switched off.
const CALM: &str = "[randomize]\nlink_mass.enabled = false\nlink_inertia.enabled = false\nlink_com.enabled = \
    false\n\
                    joint_damping.enabled = false\njoint_friction.enabled = false\nmotor_constant.enabled = \
                    false\n\
                    action_delay.enabled = false\n";

/// Rows under which joints turn freely.
pub const LOOSE: &str = "[randomize.loose_bearings]\nkind = \"joint_friction\"\nscale = 0.001\n\
                         [randomize.thin_oil]\nkind = \"joint_damping\"\nscale = 0.001\n";

/// TOCABI as the committed parents have it, without their randomization and delay: a task (`stand`, `walk`),
/// a kind of action, and more TOML.
pub fn blueprint(task: &str, control: &str, more: &str) -> Blueprint {
    let delay = if more.contains("delay = ") { "" } else { "[action]\ndelay = \"0 ms\"\n" };
    spec(&format!(
        "extends = [\"base/task/{task}.toml\", \"base/action/{control}.toml\"]\n{delay}{CALM}{more}"
    ))
}

/// The blueprint of a spec for TOCABI beside the committed ones.
pub fn spec(text: &str) -> Blueprint {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/measured.toml");
    let head = "spec = 1\nname = \"measured\"\nsummary = \"A world to measure\"\n";
    let mut files = Overlay::new(Disk);
    files.hold(&path, format!("{head}{text}\n[robot]\nmodel = \"tocabi\"\n"));
    let checked = checked_in(&files, &path, &LoadOptions::default());
    let (experiment, robot) = checked.sound().unwrap_or_else(|| panic!("{text}: {:#?}", checked.sink));
    let motion = experiment.motion.as_ref().map(|file| {
        let decoded = checked.motion.as_ref().expect("a sound spec has a sound motion");
        let section = Section::new(decoded);
        let clip = section.value(Clip::file).as_deref().and_then(motion::embedded);
        motion::build(&file.name, section, robot, clip).expect("the motion suits the robot")
    });
    Blueprint::new(experiment.table.clone(), robot.clone(), motion).expect("a checked spec has a blueprint")
}

/// Names of the engines.
pub const NAMES: [&str; 3] = ["rapier", "mujoco", "batch"];

/// All of them.
pub fn engines() -> Vec<Arc<dyn Engine>> {
    NAMES.iter().map(|name| open(name).expect("the engines are built in")).collect()
}

/// Moves the start of an episode.
type Place = Box<dyn Fn(&mut State) + Send + Sync>;

/// What an engine was given and what came of it.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// The robot that was built last.
    pub robot: Option<Robot>,
    /// The start, and the state after every physics step.
    pub states: Vec<State>,
    /// The contacts of every physics step.
    pub contacts: Vec<Contacts>,
}

/// An engine whose worlds start where the test wants them and are watched.
pub struct Watched {
    engine: Arc<dyn Engine>,
    place: Place,
    record: Arc<Mutex<Record>>,
}

impl Engine for Watched {
    fn name(&self) -> &'static str {
        self.engine.name()
    }

    fn identity(&self) -> String {
        self.engine.identity()
    }

    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        let mut state = state.clone();
        (self.place)(&mut state);
        let world = self.engine.build(robot, terrain, settings, &state)?;
        let record = Record { robot: Some(robot.clone()), states: vec![state], contacts: Vec::new() };
        *self.record.lock().expect("no test panics while it holds the record") = record;
        Ok(Box::new(WatchedWorld { world, record: self.record.clone() }))
    }
}

struct WatchedWorld {
    world: Box<dyn World>,
    record: Arc<Mutex<Record>>,
}

impl World for WatchedWorld {
    fn apply(&mut self, torque: &[f64]) {
        self.world.apply(torque);
    }

    fn advance(&mut self) {
        self.world.advance();
        let mut state = State::default();
        self.world.read(&mut state);
        let mut record = self.record.lock().expect("no test panics while it holds the record");
        record.states.push(state);
        record.contacts.push(self.world.contacts());
    }

    fn read(&self, state: &mut State) {
        self.world.read(state);
    }

    fn contacts(&self) -> Contacts {
        self.world.contacts()
    }

    fn push(&mut self, force: [f64; 3]) {
        self.world.push(force);
    }

    fn is_sane(&self) -> bool {
        self.world.is_sane()
    }
}

/// A running episode of a blueprint, randomized and without encoder noise, from the standing start.
pub struct Rig {
    /// The environment.
    pub environment: RobotEnvironment,
    record: Arc<Mutex<Record>>,
}

impl Rig {
    /// An episode that has begun where `place` moves it.
    pub fn new(
        blueprint: &Blueprint,
        engine: &Arc<dyn Engine>,
        place: impl Fn(&mut State) + Send + Sync + 'static,
    ) -> Self {
        let trial = Trial { randomized: Randomized::AsTrained, time_limit: Some(1e3), ..Trial::default() };
        Self::of_mode(blueprint, engine, place, &Mode::Evaluation(trial))
    }

    /// The same in another mode.
    pub fn of_mode(
        blueprint: &Blueprint,
        engine: &Arc<dyn Engine>,
        place: impl Fn(&mut State) + Send + Sync + 'static,
        mode: &Mode,
    ) -> Self {
        let record = Arc::new(Mutex::new(Record::default()));
        let watched = Watched { engine: engine.clone(), place: Box::new(place), record: record.clone() };
        let environment = blueprint.environment(Arc::new(watched), mode).expect("the blueprint was checked");
        let mut rig = Self { environment, record };
        rig.environment.begin("measured");
        rig
    }

    /// Takes control steps with one action, joint numbers and shares, the rest zero.
    pub fn act(&mut self, shares: &[(usize, f32)], steps: usize) -> &mut Self {
        let mut action = vec![0.0; self.environment.view().sizes().action];
        shares.iter().for_each(|(joint, share)| action[*joint] = *share);
        for _ in 0..steps {
            self.environment.step(&action);
        }
        self
    }

    /// What has happened so far.
    pub fn record(&self) -> Record {
        self.record.lock().expect("no test panics while it holds the record").clone()
    }

    /// The robot that the engine has.
    pub fn robot(&self) -> Robot {
        self.record().robot.expect("the episode has begun")
    }
}

/// Lifts a start by 20 m.
pub fn aloft(state: &mut State) {
    state.base_position[2] += 20.0;
}

/// Leaves a start as it is.
pub fn as_it_is(_: &mut State) {}

/// Pose of the base.
pub fn base(state: &State) -> Isometry3<f64> {
    let [w, x, y, z] = state.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(Vector3::from(state.base_position)), turn)
}

/// A robot's kinematics in a state.
pub fn kinematics(robot: &Robot, state: &State) -> Kinematics {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&base(state), &state.position);
    kinematics
}

/// Generalised velocity: base origin, base rate, joints.
pub fn velocity(state: &State) -> DVector<f64> {
    let all = [&state.base_velocity[..], &state.base_rate[..], &state.velocity[..]].concat();
    DVector::from_vec(all)
}

/// The generalised acceleration of a robot at rest in the air under joint torques in N m, from its mass
/// matrix.
pub fn acceleration(robot: &Robot, state: &State, torque: &[f64]) -> DVector<f64> {
    let kinematics = kinematics(robot, state);
    let mut force = DVector::zeros(6 + robot.joints());
    kinematics.gravity(&mut force);
    force.neg_mut();
    for (joint, torque) in torque.iter().enumerate() {
        force[6 + joint] += torque;
    }
    kinematics.mass_matrix().lu().solve(&force).expect("a mass matrix has an inverse")
}

/// Total vertical force of the ground on the feet in N, mean over the last physics steps.
pub fn carried(record: &Record, last: usize) -> f64 {
    let tail = &record.contacts[record.contacts.len() - last..];
    tail.iter().map(|contacts| contacts.foot_force[0][2] + contacts.foot_force[1][2]).sum::<f64>()
        / last as f64
}

/// Angle in rad of the incline on which feet slide.
const INCLINE: f64 = 0.16;

/// The robot holds its default pose on an incline with this coefficient of friction.
pub fn on_an_incline(friction: f64, more: &str) -> Blueprint {
    let text = format!(
        "[action]\nstiffness = \"100 %\"\ndelay = \"0 ms\"\n\
         [terrain]\nkind = \"slope\"\nangle = \"{INCLINE} rad\"\nfriction = {friction:?}\n{more}"
    );
    blueprint("stand", "position", &text)
}

/// Share of its load with which the ground under each foot resists while the robot slides down the incline,
/// its soles flat on it.
pub fn sliding_grip(blueprint: &Blueprint, engine: &Arc<dyn Engine>) -> [f64; 2] {
    let height = blueprint.robot.standing_height;
    let (sine, cosine) = libm::sincos(INCLINE);
    let leaning = move |state: &mut State| {
        let (half_sine, half_cosine) = libm::sincos(-0.5 * INCLINE);
        state.base_orientation = [half_cosine, 0.0, half_sine, 0.0];
        state.base_position = [-sine * height, 0.0, cosine * height];
    };
    let record = Rig::new(blueprint, engine, leaning).act(&[], 150).record();
    let moved = record.states[record.states.len() - 1].base_position[0] - record.states[0].base_position[0];
    assert!(moved < -0.02, "{}: the robot slides by {moved} m", engine.name());
    let mut sums = [[0.0; 2]; 2];
    for contacts in &record.contacts[600..] {
        for (sum, [x, y, z]) in sums.iter_mut().zip(contacts.foot_force) {
            sum[0] += libm::hypot(x * cosine + z * sine, y);
            sum[1] += z * cosine - x * sine;
        }
    }
    sums.map(|[along, normal]| along / normal)
}

/// Tells what was measured beside what was due (`cargo test ... -- --nocapture`): the figures of the design
/// documents.
pub fn tell(what: &str, engine: usize, measured: f64, due: f64) {
    println!("| {what} | {} | {measured:.5} | {due:.5} |", NAMES[engine]);
}
