//! A robot in the air: free fall, momentum, energy, the response of joints to torques, their limits and
//! friction.

use nalgebra::{DVector, Vector3};
use specforge::robot::{GRAVITY, Robot};
use specforge::sim::{Engine, State, open};

use super::lab::{anchored, bare, each, kinematics, largest, standing, velocity, weight, world};
use super::table::{Row, within};

/// The step of training in s.
const STEP: f64 = 0.002;

/// All quantities of a robot.
pub fn rows(robot: &Robot) -> Vec<Row> {
    let [linear, angular] = momentum(robot);
    let [overshoot, rest] = limits(robot);
    let [creep, slip] = friction(robot);
    vec![free_fall(robot), linear, angular, energy(robot), step_response(robot), overshoot, rest, creep, slip]
}

/// The base after 0.3 s of free fall against the sum of its steps: z + v t - g t (t + step) / 2.
fn free_fall(robot: &Robot) -> Row {
    let start = State { base_velocity: [0.5, 0.0, 1.0], ..standing(robot, 2.0) };
    let (step, time) = (0.001, 0.3);
    let figures = each(|engine| {
        let mut world = world(engine, robot, step, &start);
        (0..300).for_each(|_| world.step(&vec![0.0; robot.joints()]));
        let mut state = State::default();
        world.read(&mut state);
        let height = start.base_position[2] + time - 0.5 * GRAVITY * time * (time + step);
        1e3 * (Vector3::from(state.base_position) - Vector3::new(0.15, 0.0, height)).norm()
    });
    Row::deviation("free fall, base after 0.3 s", "z + v t - g t (t + step) / 2", "mm", within(5e-3, figures))
}

/// A state in the air with every velocity different from zero.
pub fn tumbling(robot: &Robot) -> State {
    let velocity = (0..robot.joints()).map(|joint| 0.8 - 0.15 * joint as f64).collect();
    let norm = libm::sqrt(0.81 + 0.09 + 0.09 + 0.01);
    State {
        base_velocity: [0.3, -0.2, 0.4],
        base_rate: [0.5, 1.0, -0.7],
        base_orientation: [0.9, 0.3, -0.3, 0.1].map(|part| part / norm),
        velocity,
        ..standing(robot, 3.0)
    }
}

/// Linear momentum in kg m/s and angular momentum about the centre of mass in kg m^2/s.
fn momenta(robot: &Robot, state: &State) -> [Vector3<f64>; 2] {
    let kinematics = kinematics(robot, state);
    let both = kinematics.mass_matrix() * velocity(state);
    let lever = kinematics.com().coords - Vector3::from(state.base_position);
    let linear = Vector3::new(both[0], both[1], both[2]);
    [linear, Vector3::new(both[3], both[4], both[5]) - lever.cross(&linear)]
}

/// Torques that shake every joint by some 5 rad/s^2.
fn shaking(robot: &Robot, time: f64) -> Vec<f64> {
    let strength = mobility(robot).map(|mobility| 5.0 / mobility);
    (0..robot.joints()).map(|joint| strength[joint] * libm::sin(12.0 * time + joint as f64)).collect()
}

/// Acceleration of each joint of the floating robot in the default pose per torque on it.
fn mobility(robot: &Robot) -> DVector<f64> {
    let mass = kinematics(robot, &standing(robot, 0.0)).mass_matrix();
    mass.try_inverse().expect("a mass matrix is positive").diagonal().rows(6, robot.joints()).clone_owned()
}

/// Momenta after 0.4 s of tumbling under torques of the joints, which are internal forces: friction, damping
/// and limits as well.
fn momentum(robot: &Robot) -> [Row; 2] {
    let (start, time) = (tumbling(robot), 0.4);
    let [linear, angular] = momenta(robot, &start);
    let fall = Vector3::new(0.0, 0.0, -weight(robot) * time);
    let drift = each(|engine| {
        let mut world = world(engine, robot, STEP, &start);
        (0..200).for_each(|step| world.step(&shaking(robot, STEP * f64::from(step))));
        let mut state = State::default();
        world.read(&mut state);
        let [p, l] = momenta(robot, &state);
        [(p - linear - fall).norm() / linear.norm(), (l - angular).norm() / angular.norm()]
    });
    let pick = |which: usize| drift.map(|drift| drift[which]);
    [
        Row::deviation(
            "linear momentum after 0.4 s of tumbling",
            "p - m g t",
            "relative",
            within(5e-3, pick(0)),
        ),
        Row::deviation(
            "angular momentum after 0.4 s of tumbling",
            "conserved",
            "relative",
            within(0.02, pick(1)),
        ),
    ]
}

/// Without joint friction, damping and limits: nothing takes energy.
fn without_limits(robot: &Robot) -> Robot {
    let mut free = bare(robot);
    free.links.iter_mut().for_each(|link| (link.joint.lower, link.joint.upper) = (-30.0, 30.0));
    free
}

/// What a passive tumbling robot gains in 0.4 s of the kinetic energy about its centre of mass.
fn energy(robot: &Robot) -> Row {
    let (free, start) = (without_limits(robot), tumbling(robot));
    let kinetic = |state: &State| {
        let rate = velocity(state);
        let whole = 0.5 * rate.dot(&(kinematics(&free, state).mass_matrix() * &rate));
        whole - 0.5 * momenta(&free, state)[0].norm_squared() / free.total_mass()
    };
    let figures = each(|engine| {
        let mut world = world(engine, &free, STEP, &start);
        (0..200).for_each(|_| world.step(&vec![0.0; free.joints()]));
        let mut state = State::default();
        world.read(&mut state);
        kinetic(&state) / kinetic(&start) - 1.0
    });
    Row::between("kinetic energy gained in 0.4 s of passive tumbling", "relative", figures, (-0.01, 0.01))
}

/// Joint positions after a constant torque on one joint.
fn driven(engine: &dyn Engine, robot: &Robot, (joint, torque): (usize, f64), step: f64) -> Vec<f64> {
    let mut world = world(engine, robot, step, &standing(robot, 3.0));
    let mut torques = vec![0.0; robot.joints()];
    torques[joint] = torque;
    let steps = (0.1 / step).round() as usize;
    (0..steps).for_each(|_| world.step(&torques));
    let mut state = State::default();
    world.read(&mut state);
    state.position
}

/// Each joint in turn under a torque that moves it by some 0.15 rad in 0.1 s.
fn step_response(robot: &Robot) -> Row {
    let mobility = mobility(robot);
    let torque = |joint: usize| {
        let figures = &robot.links[joint].joint;
        (joint, (30.0 / mobility[joint] + figures.friction).min(0.9 * figures.effort_limit))
    };
    let exact = open("mujoco").unwrap();
    let ends: Vec<Vec<f64>> =
        (0..robot.joints()).map(|joint| driven(exact.as_ref(), robot, torque(joint), 1e-4)).collect();
    let figures = each(|engine| {
        let errors = ends.iter().enumerate().map(|(joint, end)| {
            let is = driven(engine, robot, torque(joint), 0.0005);
            let moved = end[joint] - robot.links[joint].joint.default_position;
            let errors: Vec<f64> = is.iter().zip(end).map(|(is, should)| (is - should) / moved).collect();
            largest(&errors)
        });
        errors.fold(0.0, f64::max)
    });
    Row::deviation(
        "step response of each joint after 0.1 s, step 0.5 ms",
        "MuJoCo, step 0.1 ms",
        "relative",
        within(0.015, figures),
    )
}

/// Each joint of an anchored robot pushed from 0.05 rad below its upper limit with some 20 rad/s^2: how far
/// it goes beyond, and how far beyond it rests.
fn limits(robot: &Robot) -> [Row; 2] {
    let anchored = anchored(robot);
    let inertia = kinematics(&anchored, &standing(robot, 3.0)).mass_matrix();
    let beyond = |engine: &dyn Engine, joint: usize| {
        let figures = &anchored.links[joint].joint;
        let mut start = standing(robot, 3.0);
        start.position[joint] = figures.upper - 0.05;
        let mut torque = vec![0.0; robot.joints()];
        torque[joint] = (20.0 * inertia[(6 + joint, 6 + joint)]).min(0.5 * figures.effort_limit);
        let mut world = world(engine, &anchored, STEP, &start);
        let (mut state, mut most) = (State::default(), f64::NEG_INFINITY);
        for _ in 0..150 {
            world.step(&torque);
            world.read(&mut state);
            most = most.max(state.position[joint] - figures.upper);
        }
        [most, state.position[joint] - figures.upper]
    };
    let found = each(|engine| {
        let joints = (0..robot.joints()).map(|joint| beyond(engine, joint));
        joints.fold([f64::NEG_INFINITY; 2], |[a, b], [c, d]| [a.max(c), b.max(d)])
    });
    let pick = |which: usize| found.map(|found| found[which]);
    [
        Row::between("joint limits: overshoot at 1.4 rad/s, worst joint", "rad", pick(0), (1e-3, 0.03)),
        Row::between("joint limits: rest beyond the limit, worst joint", "rad", pick(1), (0.0, 5e-3)),
    ]
}

/// Each joint of an anchored robot with a friction that a torque twice as large overcomes with 2 rad/s^2, the
/// others stuck: the rate of creep under 95 % of the friction, and the acceleration under twice of it against
/// (torque - friction) / M_ii.
fn friction(robot: &Robot) -> [Row; 2] {
    let pose = standing(robot, 3.0);
    let anchored = anchored(robot);
    let inertia = kinematics(&anchored, &pose).mass_matrix().diagonal().rows(6, robot.joints()).clone_owned();
    let rate = |engine: &dyn Engine, joint: usize, share: f64| {
        let mut gripped = anchored.clone();
        gripped.links.iter_mut().for_each(|link| link.joint.friction = 1000.0);
        gripped.links[joint].joint.friction = 2.0 * inertia[joint];
        let mut torque = vec![0.0; robot.joints()];
        torque[joint] = share * gripped.links[joint].joint.friction;
        let mut world = world(engine, &gripped, STEP, &pose);
        (0..25).for_each(|_| world.step(&torque));
        let mut state = State::default();
        world.read(&mut state);
        state.velocity[joint]
    };
    let worst = |engine: &dyn Engine, error: &dyn Fn(&dyn Engine, usize) -> f64| {
        (0..robot.joints()).map(|joint| error(engine, joint).abs()).fold(0.0, f64::max)
    };
    let creep = each(|engine| worst(engine, &|engine, joint| rate(engine, joint, 0.95)));
    let slip =
        each(|engine| worst(engine, &|engine, joint| rate(engine, joint, 2.0) / (2.0 * 25.0 * STEP) - 1.0));
    [
        Row::deviation(
            "friction loss: creep under 95 % of it, worst joint",
            "0",
            "rad/s",
            within(0.02, creep),
        ),
        Row::deviation(
            "friction loss: acceleration under twice of it",
            "(tau - friction) / M_ii",
            "relative",
            within(0.12, slip),
        ),
    ]
}
