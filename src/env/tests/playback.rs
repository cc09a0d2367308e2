//! The reference played by a PD servo with gravity feed-forward in rapier, without a policy: shows that
//! reference, schedule, contacts, frames and reward agree.

use std::sync::Arc;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::Recipe;
use crate::env::{End, Mode, RobotEnvironment, Trial};
use crate::kinds::motion::Frame;
use crate::robot::{GRAVITY, GravityCompensation, Weighting};
use crate::sim::rapier::Rapier;

const SERVO: &str = "kind = \"position\"\nstd = \"1 %\"\nservo_rate = \"500 Hz\"\nstiffness = \"100 %\"\n";

/// Position control at the robot's own gains.
fn servo(robot: &'static str, motion: Option<&'static str>) -> Recipe {
    let mut recipe = Recipe::new(robot, motion);
    (recipe.action, recipe.symmetry, recipe.kernel) = (SERVO.into(), "none", 3.0);
    recipe.more =
        "[terminate.base_height]\nbelow = \"0.6 m\"\n[terminate.base_tilt]\nabove = \"0.6 rad\"\n".into();
    recipe
}

/// The action with which the servo tracks the reference, with feed-forward torques for the scheduled
/// contacts.
fn follow(environment: &RobotEnvironment, compensation: &mut GravityCompensation, action: &mut [f32]) {
    let law = &environment.scene().law;
    // An environment does not store the accelerations of its reference.
    let mut reference = Frame::default();
    environment.scene().motion().at(environment.signals().phase, &mut reference);
    let [w, x, y, z] = reference.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    // The base accelerates: statics in the direction and strength of the felt weight.
    let felt = Vector3::from(reference.base_acceleration) + Vector3::z() * GRAVITY;
    let tilt = UnitQuaternion::rotation_between(&felt, &Vector3::z()).unwrap();
    let base = Isometry3::from_parts(Translation3::identity(), tilt * turn);
    let share = felt.norm() / GRAVITY;
    let balance = compensation.hold(&base, &reference.position, reference.contact);
    let torque: Vec<f64> = balance.torque.iter().map(|torque| share * torque).collect();
    let mut wanted = vec![0.0; torque.len()];
    // q_ref + (tau + K_d qd_ref) / K_p: the servo's own damping is compensated along the reference.
    law.action(&torque, &reference.position, &reference.velocity, &mut wanted);
    action.iter_mut().zip(&wanted).for_each(|(action, wanted)| *action = *wanted as f32);
}

/// Result of a playback.
#[derive(Clone, Copy, Debug, Default)]
struct Playback {
    /// Seconds until it ended.
    time: f64,
    /// Mean reward per step.
    reward: f64,
    /// Mean forward speed in m/s.
    speed: f64,
    /// Share of the steps whose contacts match the schedule.
    matched: f64,
}

fn play(recipe: &Recipe, mode: &Mode, stream: &str, limit: f64) -> Playback {
    let blueprint = recipe.blueprint();
    let mut environment = blueprint.environment(Arc::new(Rapier), mode).unwrap();
    let mut compensation = GravityCompensation::new(&blueprint.robot, Weighting::EffortLimits);
    let mut action = vec![0.0; blueprint.sizes().action];
    environment.begin(stream);
    let start = environment.state().base_position[0];
    let (mut reward, mut matches, mut steps) = (0.0, 0.0, 0.0);
    loop {
        follow(&environment, &mut compensation, &mut action);
        let step = environment.step(&action);
        assert_ne!(step.end, Some(End::Exploded));
        let signals = environment.signals();
        steps += 1.0;
        reward += step.reward;
        matches += f64::from(u8::from(signals.foot_contact == signals.reference.contact));
        let time = signals.time;
        if step.end.is_some() || time > limit - 1e-9 {
            let speed = (environment.state().base_position[0] - start) / time;
            return Playback { time, reward: reward / steps, speed, matched: matches / steps };
        }
    }
}

/// Starts on the reference, without noise.
const EXACT: &str = "kind = \"reference\"\nstanding_share = \"0 %\"\nposition_noise = \"0 rad\"\n\
                     velocity_noise = \"0 rad/s\"\nbase_velocity_noise = \"0 m/s\"\nbase_rate_noise = \"0 \
                     rad/s\"\n";

#[test]
fn the_servo_stands_and_pays_what_standing_pays() {
    let found = play(&servo("tocabi", None), &Mode::Evaluation(Trial::default()), "test", 4.0);
    println!("tocabi stands: {found:.3?}");
    assert!(found.time > 3.9 && found.speed.abs() < 0.01 && found.matched > 0.99 && found.reward > 1.5);
}

#[test]
fn the_walk_is_playable_from_the_reference() {
    // A prototype without the inertial part of the torques reached 0.133 m/s, 0.93 and 1.362.
    for stream in ["a", "b"] {
        let mut recipe = servo("tocabi", Some("walk"));
        (recipe.speed, recipe.initial) = ("\"0.1247 m/s\"", EXACT.into());
        let found = play(&recipe, &Mode::Training, stream, 6.0);
        println!("tocabi walks: {found:.3?}");
        assert!(found.time > 5.9 && (0.11..0.17).contains(&found.speed));
        assert!(found.matched > 0.9 && found.reward > 1.4);
    }
}

#[test]
fn the_run_is_playable_for_a_few_steps() {
    // In open loop it soon falls; each of its half cycles lasts 0.33 s.
    let mut longest = Playback::default();
    for stream in ["a", "b", "c", "d"] {
        let mut recipe = servo("tocabi", Some("run_gait"));
        (recipe.speed, recipe.initial) = ("\"0.8 m/s\"", EXACT.into());
        let found = play(&recipe, &Mode::Training, stream, 3.0);
        println!("tocabi runs: {found:.3?}");
        longest = if found.time > longest.time { found } else { longest };
    }
    assert!(longest.time > 0.7 && longest.speed > 0.4, "{longest:?}");
}
