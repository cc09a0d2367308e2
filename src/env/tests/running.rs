//! Episodes in rapier: repeatable, and with little overhead over the physics.

use std::sync::Arc;

use super::Recipe;
use crate::env::Mode;
use crate::kinds::motion::Frame;
use crate::sim::rapier::Rapier;
use crate::stream::Stream;

const REFERENCE: &str = "kind = \"reference\"\n";

/// Rewards and observations of random actions over episodes.
fn trace(streams: &[&str]) -> Vec<f64> {
    let mut recipe = Recipe::new("atlas", Some("run_gait"));
    recipe.initial = REFERENCE.into();
    recipe.more = "[terminate.base_height]\nbelow = \"0.7 m\"\n[randomize.link_mass]\n\
                   scale = { uniform = [0.6, 1.4] }\n"
        .into();
    let mut environment = recipe.blueprint().environment(Arc::new(Rapier), &Mode::Training).unwrap();
    let mut observation = vec![0.0; environment.view().sizes().privileged];
    let mut trace = Vec::new();
    for stream in streams {
        environment.begin(stream);
        trace.clear();
        let mut noise = Stream::new(&format!("{stream}/action"));
        for _ in 0..60 {
            let action: Vec<f32> = (0..13).map(|_| 0.1 * noise.normal() as f32).collect();
            let step = environment.step(&action);
            environment.view().observe_privileged(&mut observation);
            trace.push(step.reward);
            trace.extend(observation.iter().map(|number| f64::from(*number)));
            if step.end.is_some() {
                break;
            }
        }
    }
    trace
}

#[test]
fn an_episode_repeats_bit_for_bit_whatever_came_before() {
    let alone = trace(&["b"]);
    assert!(alone.len() > 200);
    assert_eq!(alone, trace(&["a", "c", "b"]));
    assert_ne!(alone, trace(&["c"]));
}

#[test]
fn a_start_on_the_running_reference_shows_velocities_that_lag() {
    let mut recipe = Recipe::new("tocabi", Some("run_gait"));
    recipe.symmetry = "none";
    recipe.initial = "kind = \"reference\"\nstanding_share = \"0 %\"\n".into();
    let blueprint = recipe.blueprint();
    let mut environment = blueprint.environment(Arc::new(Rapier), &Mode::Training).unwrap();
    let motion = blueprint.reference();
    let (mut now, mut before) = (Frame::default(), Frame::default());
    for episode in 0..5 {
        environment.begin(&format!("test/{episode}"));
        let mut observation = vec![0.0; environment.view().sizes().observation];
        environment.view().observe(&mut observation);
        let phase = environment.signals().phase;
        // The knee's first harmonics: a first-order lag of 40 ms attenuates velocities and delays them by
        // about 30 ms.
        motion.at(phase, &mut now);
        motion.at(phase - 0.03 / motion.period, &mut before);
        let shown = f64::from(observation[3 + 12 + 3]) * 0.998;
        let (fresh, old) = ((shown - now.velocity[3]).abs(), (shown - before.velocity[3]).abs());
        assert!(
            old < 3.5 && (old < fresh || fresh < 1.5),
            "{shown} {} {}",
            now.velocity[3],
            before.velocity[3]
        );
    }
}

#[test]
fn standing_starts_are_perturbed_where_the_spec_says_so() {
    let starts = |kind: &str, noise: &str| -> Vec<f64> {
        let mut recipe = Recipe::new("tocabi", Some("run_gait"));
        recipe.initial = format!("kind = \"{kind}\"\n{noise}");
        let blueprint = recipe.blueprint();
        let mut environment = blueprint.environment(Arc::new(Rapier), &Mode::Training).unwrap();
        let pose = blueprint.robot.default_pose();
        let mut apart = Vec::new();
        for episode in 0..40 {
            environment.begin(&format!("test/{episode}"));
            let signals = environment.signals();
            if signals.standing_start {
                apart.extend(signals.position.iter().zip(&pose).map(|(is, default)| is - default));
            }
        }
        apart
    };
    for kind in ["default_pose", "reference"] {
        let noisy = starts(kind, "standing_noise = { normal = [\"0 rad\", \"0.01 rad\"] }\n");
        assert!(noisy.len() >= 12);
        let deviation = (noisy.iter().map(|angle| angle * angle).sum::<f64>() / noisy.len() as f64).sqrt();
        assert!((deviation - 0.01).abs() < 0.004, "{kind}: {deviation}");
        assert!(starts(kind, "").iter().all(|angle| angle.abs() < 1e-6), "{kind}");
    }
}

#[test]
fn a_start_on_the_reference_at_rest_has_its_pose_and_no_velocities() {
    let mut recipe = Recipe::new("tocabi", Some("run_gait"));
    recipe.symmetry = "none";
    let exact = "kind = \"reference\"\nstanding_share = \"0 %\"\nposition_noise = \"0 rad\"\nvelocity_noise \
        = \"0 rad/s\"\n\
                 base_velocity_noise = \"0 m/s\"\nbase_rate_noise = \"0 rad/s\"\n";
    let fastest = |more: &str| {
        let mut recipe = recipe.clone();
        recipe.initial = String::from(exact) + more;
        let blueprint = recipe.blueprint();
        let mut environment = blueprint.environment(Arc::new(Rapier), &Mode::Training).unwrap();
        let (mut expected, mut fastest) = (Frame::default(), 0.0f64);
        for episode in 0..5 {
            environment.begin(&format!("test/{episode}"));
            blueprint.reference().at(environment.signals().phase, &mut expected);
            let state = environment.state();
            let apart = state.position.iter().zip(&expected.position).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-5);
            let mut observation = vec![0.0; environment.view().sizes().observation];
            environment.view().observe(&mut observation);
            let shown = observation[15..27].iter().map(|velocity| f64::from(*velocity));
            let moving = state.velocity.iter().chain(&state.base_velocity).chain(&state.base_rate).copied();
            fastest = moving.chain(shown).map(f64::abs).fold(fastest, f64::max);
        }
        fastest
    };
    assert!(fastest("") > 1.0);
    assert!(fastest("velocities = \"reference\"\n") > 1.0);
    assert!(fastest("velocities = \"rest\"\n") < 1e-6);
}
