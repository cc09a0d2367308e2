//! The reward of the reference motion, and of standing still: the table of docs/explanation/reward.md.

use super::Recipe;
use crate::env::scene;
use crate::env::standing::Moment;
use crate::kinds::motion::Frame;
use crate::robot::{GravityCompensation, SelfCollision, Weighting};

/// Mean reward per step by term, over a cycle of 125 Hz steps: moving with the reference, or standing.
fn rewards(recipe: &Recipe, stands: bool, command: f64) -> Vec<(String, f64)> {
    let blueprint = recipe.blueprint();
    let motion = blueprint.reference().into_owned();
    let mut compensation = GravityCompensation::new(&blueprint.robot, Weighting::EffortLimits);
    let still = Moment::standing(&blueprint.robot);
    let steps = (motion.period * 125.0).round() as usize;
    let mut at = |step: usize| {
        let mut frame = Frame::default();
        motion.at(step as f64 / steps as f64, &mut frame);
        (if stands { still.clone() } else { Moment::at(&frame, &mut compensation) }, frame)
    };
    let (terms, names) = scene::rewards(blueprint.section("reward"));
    let mut sums = vec![0.0; terms.len()];
    let (mut before, _) = at(steps - 1);
    for step in 0..steps {
        let (now, reference) = at(step);
        let signals = now.signals(&before, 0.008, &reference, command);
        for (sum, (weight, term)) in sums.iter_mut().zip(&terms) {
            *sum += weight * term.value(&signals) / steps as f64;
        }
        before = now;
    }
    names.into_iter().zip(sums).collect()
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
fn the_return_of_standing_is_the_reward_per_step_over_the_whole_time_limit() {
    // 16 s at 125 Hz are 2000 steps; the commanded speed is one or a range.
    let standing = |speed: &'static str| {
        let mut recipe = Recipe::new("tocabi", Some("walk"));
        (recipe.speed, recipe.kernel) = (speed, 20.0);
        (recipe.blueprint().standing_return(), recipe)
    };
    let (one, recipe) = standing("\"0.2 m/s\"");
    let per_step = total(&rewards(&recipe, true, 0.2));
    assert!((one / 2000.0 - per_step).abs() < 2e-3, "{one} and {per_step}");
    let (range, _) = standing("{ uniform = [\"0.1 m/s\", \"0.3 m/s\"] }");
    let speeds = [0.1, 0.15, 0.2, 0.25, 0.3].map(|speed| total(&rewards(&recipe, true, speed)));
    // Simpson's rule.
    let mean = (speeds[0] + 4.0 * speeds[1] + 2.0 * speeds[2] + 4.0 * speeds[3] + speeds[4]) / 12.0;
    assert!((range / 2000.0 - mean).abs() < 2e-3, "{range} and {mean}");
    assert!((range - one).abs() > 1.0, "the range of speeds counts");
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
