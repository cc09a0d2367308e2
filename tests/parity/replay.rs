//! Open-loop replay: the torques that one engine's position control needed, played to it and another from the
//! same start, until a joint is 0.05 rad apart. Nothing corrects the motion, so this is the hardest
//! comparison: a standing robot is an inverted pendulum, and a difference grows by itself.

use specforge::robot::{Leg, Robot};
use specforge::sim::{Engine, State, open};

use super::lab::{standing, world};
use super::table::Row;

/// Step in s.
const STEP: f64 = 0.0005;
/// Length of the tape in s.
const LENGTH: f64 = 1.0;
/// Multiple of the robot's own stiffness; the damping has its root.
const GAIN: f64 = 4.0;
/// How far apart the joints may be, in rad.
const APART: f64 = 0.05;

/// All quantities of a robot: the tape of each engine, played to another one.
pub fn rows(robot: &Robot) -> Vec<Row> {
    let [rapier, mujoco, batch] = ["rapier", "mujoco", "batch"].map(|name| open(name).unwrap());
    let times = [(&rapier, &mujoco), (&mujoco, &rapier), (&batch, &rapier)].map(|(one, other)| {
        let tape = record(one.as_ref(), robot);
        let [own, others] = [one, other].map(|engine| play(engine.as_ref(), robot, &tape));
        coarse(time_apart(&own, &others))
    });
    vec![Row::between("open-loop replay on the ground: 0.05 rad apart after", "s", times, (0.1, LENGTH))]
}

/// Joint positions of a robot that squats and sways.
fn swaying(robot: &Robot, time: f64) -> Vec<f64> {
    let (squat, sway) = (0.3 * libm::sin(6.0 * time), 0.04 * libm::sin(4.0 * time));
    let mut position: Vec<f64> = robot.default_pose().iter().map(|rest| rest * (1.0 + squat)).collect();
    for leg in [0, 1].map(|side| Leg::of(robot, side).expect("a leg with six joints")) {
        position[leg.hip_roll.0] += leg.hip_roll.1 * sway;
        position[leg.ankle_roll.0] -= leg.ankle_roll.1 * sway;
    }
    position
}

/// The torques with which position control makes the robot squat and sway.
fn record(engine: &dyn Engine, robot: &Robot) -> Vec<Vec<f64>> {
    let mut world = world(engine, robot, STEP, &standing(robot, 0.0));
    let mut state = State::default();
    let torques = (0..(LENGTH / STEP) as usize).map(|step| {
        world.read(&mut state);
        let target = swaying(robot, STEP * step as f64);
        let torque: Vec<f64> = robot
            .links
            .iter()
            .enumerate()
            .map(|(index, link)| {
                let joint = &link.joint;
                let pull = joint.stiffness_gain * GAIN * (target[index] - state.position[index]);
                let brake = joint.damping_gain * GAIN.sqrt() * state.velocity[index];
                (pull - brake).clamp(-joint.effort_limit, joint.effort_limit)
            })
            .collect();
        world.step(&torque);
        torque
    });
    torques.collect()
}

/// Joint positions under the torques of a tape, step by step.
fn play(engine: &dyn Engine, robot: &Robot, tape: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut world = world(engine, robot, STEP, &standing(robot, 0.0));
    let mut state = State::default();
    let positions = tape.iter().map(|torque| {
        world.step(torque);
        world.read(&mut state);
        state.position.clone()
    });
    positions.collect()
}

/// Time in s at which two motions are first apart; the length of the tape when they never are.
fn time_apart(one: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let apart = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > APART || (a - b).is_nan())
    };
    one.iter().zip(other).position(apart).map_or(LENGTH, |step| step as f64 * STEP)
}

/// Rounded to 0.05 s: the motion is chaotic.
fn coarse(time: f64) -> f64 {
    (time / 0.05).round() * 0.05
}
