//! The reward of the reference motion, and of standing still: the table of docs/explanation/reward.md.
//!
//! Played kinematically: joints and base follow the reference (or rest in the default pose); torques and foot
//! forces are those of gravity compensation, for running times 1 + a_z / g.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::Recipe;
use crate::env::tally;
use crate::kinds::motion::Frame;
use crate::kinds::{Signals, reward};
use crate::robot::{GRAVITY, GravityCompensation, Robot, SelfCollision, Weighting};
use crate::spec::Section;
use crate::spec::section::RewardTerm;

/// One control step of a robot that follows its command exactly.
#[derive(Clone, Debug, Default)]
struct Moment {
    frame: Frame,
    torque: Vec<f64>,
    force: [[f64; 3]; 2],
}

fn moment(frame: &Frame, compensation: &mut GravityCompensation) -> Moment {
    let [w, x, y, z] = frame.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let base = Isometry3::from_parts(Translation3::new(0.0, 0.0, frame.base_height), turn);
    let share = (1.0 + frame.base_acceleration[2] / GRAVITY).max(0.0);
    let balance = compensation.hold(&base, &frame.position, frame.contact);
    Moment {
        frame: frame.clone(),
        torque: balance.torque.iter().map(|torque| share * torque).collect(),
        force: [0, 1].map(|foot| [0, 1, 2].map(|axis| share * balance.wrench[foot][axis])),
    }
}

/// Mean reward per step by term, over a cycle of 125 Hz steps: moving with the reference, or standing.
fn rewards(recipe: &Recipe, stands: bool, command: f64) -> Vec<(String, f64)> {
    let blueprint = recipe.blueprint();
    let motion = blueprint.reference().into_owned();
    let robot: &Robot = &blueprint.robot;
    let mut compensation = GravityCompensation::new(robot, Weighting::EffortLimits);
    let still = Frame {
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        base_height: robot.standing_height,
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [true; 2],
        ..Frame::default()
    };
    let steps = (motion.period * 125.0).round() as usize;
    let at = |step: usize, compensation: &mut GravityCompensation| {
        let mut frame = Frame::default();
        motion.at(step as f64 / steps as f64, &mut frame);
        (moment(if stands { &still } else { &frame }, compensation), frame)
    };
    let section = blueprint.section("reward");
    let mut sums: Vec<(String, f64)> = section.sections().map(|(name, _)| (name.to_owned(), 0.0)).collect();
    let (mut before, _) = at(steps - 1, &mut compensation);
    for step in 0..steps {
        let (now, reference) = at(step, &mut compensation);
        let signals = signals(&now, &before, &reference, command);
        for ((_, sum), (name, term)) in sums.iter_mut().zip(section.sections()) {
            *sum += value(name, term, &signals) / steps as f64;
        }
        before = now;
    }
    sums
}

fn value(name: &str, term: Section, signals: &Signals) -> f64 {
    let entry = reward::KINDS.iter().find(|entry| entry.kind.name == name).unwrap();
    term.value(RewardTerm::weight).unwrap() * (entry.build)(term).value(signals)
}

fn signals<'a>(now: &'a Moment, before: &'a Moment, reference: &'a Frame, command: f64) -> Signals<'a> {
    Signals {
        step: 0.008,
        time: 1.0,
        phase: 0.0,
        phase_step: 0.0,
        reference,
        command_speed: command,
        base_position: [0.0, 0.0, now.frame.base_height],
        base_height: now.frame.base_height,
        stature: 1.0,
        base_orientation: now.frame.base_orientation,
        base_velocity: now.frame.base_velocity,
        mean_velocity: now.frame.base_velocity,
        base_rate: now.frame.base_rate,
        position: &now.frame.position,
        velocity: &now.frame.velocity,
        previous_velocity: &before.frame.velocity,
        torque: &now.torque,
        previous_torque: &before.torque,
        foot_force: now.force,
        previous_foot_force: before.force,
        foot_contact: tally::contact(&now.force),
        body_contact: false,
        self_collision: false,
        standing_start: false,
    }
}

/// Motion, command in m/s, k of the velocity kernel.
const CASES: [(&str, f64, f64); 5] = [
    ("squat", 0.0, 3.0),
    ("walk", 0.134, 3.0),
    ("walk", 0.134, 20.0),
    ("walk", 0.2, 20.0),
    ("run_gait", 0.8, 5.0),
];

fn total(terms: &[(String, f64)]) -> f64 {
    terms.iter().map(|(_, value)| value).sum()
}

#[test]
fn the_reference_pays_more_than_standing_for_every_task_and_robot() {
    for robot in ["tocabi", "atlas"] {
        for (motion, command, kernel) in CASES {
            let mut recipe = Recipe::new(robot, Some(motion));
            (recipe.kernel, recipe.symmetry) = (kernel, "none");
            let (moves, stands) = (rewards(&recipe, false, command), rewards(&recipe, true, command));
            println!("{robot} {motion} at {command} m/s, k {kernel}:");
            for ((name, moving), (_, standing)) in moves.iter().zip(&stands) {
                println!("  {name:22} {moving:.3} {standing:.3}");
            }
            println!("  {:22} {:.3} {:.3}", "total", total(&moves), total(&stands));
            assert!(total(&moves) < 1.70 && total(&stands) < 1.70);
            assert!(total(&moves) > total(&stands), "{robot} {motion}");
        }
    }
}

#[test]
fn standing_on_the_walking_task_is_the_local_optimum_of_the_prototype() {
    // 1.37 per step at 0.134 m/s with k 3, 1.20 at 0.2 m/s with k 20.
    for (command, kernel, expected) in [(0.134, 3.0, 1.37), (0.2, 20.0, 1.20)] {
        let mut recipe = Recipe::new("tocabi", Some("walk"));
        recipe.kernel = kernel;
        let found = total(&rewards(&recipe, true, command));
        assert!((found - expected).abs() < 0.03, "{found}");
    }
}

#[test]
fn every_reference_keeps_the_links_of_every_robot_apart() {
    for name in crate::robot::names() {
        let robot = crate::robot::tests::robot(name);
        let mut guard = SelfCollision::new(&robot, SelfCollision::pairs(&robot));
        let mut frame = Frame::default();
        for file in ["walk", "squat", "run_gait", "run_clip"] {
            let motion = crate::kinds::motion::shipped(file, &robot)
                .expect("it comes with the program")
                .expect("it suits");
            for step in 0..200 {
                motion.at(f64::from(step) / 200.0, &mut frame);
                assert_eq!(guard.find(&frame.position), None, "{name}, {file}, {step}");
            }
        }
    }
}
