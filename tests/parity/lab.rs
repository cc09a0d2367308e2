//! The laboratory of the parity suite: its robots, their doctored copies, and worlds of every engine.

use std::sync::Arc;

use nalgebra::{DVector, Isometry3, Matrix3, Matrix6xX, Quaternion, Translation3, UnitQuaternion, Vector3};
use specforge::robot::{self, GRAVITY, Kinematics, Robot};
use specforge::sim::{Engine, EngineSettings, State, Terrain, World, open};
use specforge::stream::Stream;

use super::biped;

/// Mass in kg and moments of inertia in kg m^2 of a base that its legs cannot move.
const ANCHOR: f64 = 1e7;
/// Reflected inertia in kg m^2 of a joint that nothing can move.
const FROZEN: f64 = 1e6;

/// The robots of the suite: the shipped ones and the exactly symmetric biped.
pub fn robots() -> Vec<Robot> {
    let mut robots: Vec<Robot> = robot::names().filter_map(robot::shipped).collect();
    robots.push(biped::biped());
    robots
}

/// The engines in the order of the page's columns.
const NAMES: [&str; 3] = ["rapier", "mujoco", "batch"];

/// A figure of each engine.
pub fn each<T>(measure: impl Fn(&dyn Engine) -> T) -> [T; 3] {
    NAMES.map(|name| measure(open(name).unwrap().as_ref()))
}

pub fn engines() -> Vec<Arc<dyn Engine>> {
    NAMES.iter().map(|name| open(name).unwrap()).collect()
}

pub fn settings(step: f64) -> EngineSettings {
    EngineSettings { step, friction: 1.0, contact_time: None }
}

/// A world on flat, rough ground.
pub fn world(engine: &dyn Engine, robot: &Robot, step: f64, state: &State) -> Box<dyn World> {
    engine.build(robot, &Terrain::Flat, &settings(step), state).unwrap()
}

/// The default pose at rest, some metres above the ground on which it stands.
pub fn standing(robot: &Robot, lift: f64) -> State {
    at_rest(&Isometry3::translation(0.0, 0.0, robot.standing_height + lift), robot.default_pose())
}

/// A pose at rest.
pub fn at_rest(base: &Isometry3<f64>, position: Vec<f64>) -> State {
    let turn = base.rotation;
    State {
        base_position: base.translation.vector.into(),
        base_orientation: [turn.w, turn.i, turn.j, turn.k],
        velocity: vec![0.0; position.len()],
        position,
        ..State::default()
    }
}

/// A random pose at rest in the air: the base turned anyhow, the joints in the middle four fifths of their
/// ranges.
pub fn random_pose(robot: &Robot, stream: &mut Stream) -> State {
    let [w, x, y, z] = [(); 4].map(|()| stream.normal());
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let joints = robot.links.iter().map(|link| {
        let joint = &link.joint;
        joint.lower + (joint.upper - joint.lower) * (0.1 + 0.8 * stream.uniform())
    });
    at_rest(&Isometry3::from_parts(Translation3::new(0.0, 0.0, 3.0), turn), joints.collect())
}

/// World from base.
pub fn base(state: &State) -> Isometry3<f64> {
    let [w, x, y, z] = state.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(Vector3::from(state.base_position)), turn)
}

/// The robot's kinematics in a state's pose.
pub fn kinematics(robot: &Robot, state: &State) -> Kinematics {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&base(state), &state.position);
    kinematics
}

/// The generalised velocity of a state, in the order of [`Kinematics`].
pub fn velocity(state: &State) -> DVector<f64> {
    let base = state.base_velocity.iter().chain(&state.base_rate);
    DVector::from_iterator(6 + state.velocity.len(), base.chain(&state.velocity).copied())
}

/// Without joint friction, damping and shapes other than the soles.
pub fn bare(robot: &Robot) -> Robot {
    let mut bare = robot.clone();
    bare.base.collisions.clear();
    for link in &mut bare.links {
        (link.joint.friction, link.joint.damping) = (0.0, 0.0);
        link.body.collisions.clear();
    }
    bare
}

/// With a base so heavy that nothing the legs do moves it.
pub fn anchored(robot: &Robot) -> Robot {
    let mut anchored = bare(robot);
    anchored.base.mass = ANCHOR;
    anchored.base.inertia = Matrix3::from_diagonal_element(ANCHOR);
    anchored
}

/// With joints that nothing moves: one rigid body.
pub fn statue(robot: &Robot) -> Robot {
    let mut statue = bare(robot);
    statue.links.iter_mut().for_each(|link| link.joint.armature = FROZEN);
    statue
}

/// Joint torques in N m and a force in N at the base's centre of mass, world frame.
pub struct Load {
    pub torque: Vec<f64>,
    pub push: [f64; 3],
}

impl Load {
    pub fn none(robot: &Robot) -> Self {
        Self { torque: vec![0.0; robot.joints()], push: [0.0; 3] }
    }

    /// A torque at one joint.
    pub fn at(robot: &Robot, joint: usize, torque: f64) -> Self {
        let mut load = Self::none(robot);
        load.torque[joint] = torque;
        load
    }

    /// Its generalised force on a robot in a pose.
    pub fn generalised(&self, robot: &Robot, kinematics: &Kinematics) -> DVector<f64> {
        let size = 6 + robot.joints();
        let mut jacobian = Matrix6xX::zeros(size);
        kinematics.jacobian(None, &(kinematics.base() * robot.base.com), &mut jacobian);
        let mut force = jacobian.fixed_rows::<3>(0).transpose() * Vector3::from(self.push);
        self.torque.iter().enumerate().for_each(|(joint, torque)| force[6 + joint] += torque);
        force
    }
}

/// The acceleration that an engine gives a robot at rest under a load and gravity: its velocity after one
/// step of 0.1 ms, by that time.
pub fn acceleration(engine: &dyn Engine, robot: &Robot, pose: &State, load: &Load) -> DVector<f64> {
    let step = 1e-4;
    let mut world = world(engine, robot, step, pose);
    world.push(load.push);
    world.step(&load.torque);
    let mut state = State::default();
    world.read(&mut state);
    velocity(&state) / step
}

/// The acceleration under a load without that of gravity.
pub fn response(engine: &dyn Engine, robot: &Robot, pose: &State, load: &Load) -> DVector<f64> {
    acceleration(engine, robot, pose, load) - acceleration(engine, robot, pose, &Load::none(robot))
}

/// The acceleration of a robot at rest under a load and gravity by the model.
pub fn modelled(robot: &Robot, pose: &State, load: &Load) -> DVector<f64> {
    let kinematics = kinematics(robot, pose);
    let mut weight = DVector::zeros(6 + robot.joints());
    kinematics.gravity(&mut weight);
    let force = load.generalised(robot, &kinematics) - weight;
    kinematics.mass_matrix().cholesky().expect("a mass matrix is positive").solve(&force)
}

/// Weight in N.
pub fn weight(robot: &Robot) -> f64 {
    robot.total_mass() * GRAVITY
}

/// The largest magnitude of some numbers.
pub fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    numbers
        .into_iter()
        .fold(0.0, |most, number| if number.abs() > most || number.is_nan() { number.abs() } else { most })
}
