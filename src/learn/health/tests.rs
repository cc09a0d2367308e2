//! Each check is triggered by a real training of the toy if that takes about a second, otherwise by
//! handwritten metrics. A healthy training, of the toy or of a robot, has no findings.

use std::collections::BTreeMap;

use super::*;
use crate::env::{Crew, Output};
use crate::learn::finding::{Finding, cure};
use crate::learn::settings::{Rate, Settings};
use crate::learn::toy::{self, Toy};
use crate::learn::{Activation, Network, Start, Training, UpdateMetrics, Watch, train};
use crate::stream::Stream;

struct Patient;

impl Watch for Patient {
    fn update(&self, _: &UpdateMetrics) {}

    fn interrupted(&self) -> bool {
        false
    }
}

/// 24 updates of 300 samples; the critic's step size is that of the other tests.
fn settings(rate: Rate) -> Settings {
    Settings { samples: 7200, rate, ..toy::settings() }
}

/// A toy that declares other outputs or reward ranges.
fn toy(change: impl FnOnce(&mut Toy)) -> Toy {
    let mut toy = Toy::new();
    change(&mut toy);
    toy
}

/// The findings of a training, and its metrics.
fn trained(
    settings: &Settings,
    init: Option<&Network>,
    make: impl Fn() -> Toy,
) -> (Vec<Finding>, Vec<UpdateMetrics>) {
    let scratch = tempfile::tempdir().unwrap();
    let crew = (0..settings.environments).map(|_| Box::new(make()) as Box<dyn Crew>).collect();
    let trained = train(
        Training {
            settings,
            start: Start { actor: init, critic: None },
            scratch: scratch.path(),
            threads: &|| 1,
            watch: &Patient,
        },
        crew,
    )
    .unwrap();
    let lines = std::fs::read_to_string(&trained.metrics).unwrap();
    let lines: Vec<UpdateMetrics> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let begun: Vec<&Finding> = lines.iter().flat_map(|line| &line.warnings).collect();
    let summed = trained.summary.warnings.unwrap();
    assert_eq!(begun.len(), summed.len(), "the summary has what the lines had");
    assert!(
        begun
            .iter()
            .zip(&summed)
            .all(|(a, b)| (&a.code, &a.message, a.since) == (&b.code, &b.message, b.since))
    );
    (summed, lines)
}

fn codes(findings: &[Finding]) -> Vec<&str> {
    findings.iter().map(|finding| finding.code.as_str()).collect()
}

fn of<'a>(findings: &'a [Finding], code: &str) -> &'a Finding {
    findings
        .iter()
        .find(|finding| finding.code == code)
        .unwrap_or_else(|| panic!("no {code} in {findings:#?}"))
}

#[test]
fn a_training_that_reaches_the_optimum_is_well() {
    let rate = Rate::Linear([1e-3, 1e-4]);
    let settings = Settings { samples: 60_000, rollout: 500, epochs: 6, std: vec![0.25], ..settings(rate) };
    let (findings, lines) = trained(&settings, None, Toy::new);
    assert_eq!(findings, []);
    let last = lines.last().unwrap();
    let spread = last.action_spread["pull"];
    // The best action is half the state, whose standard deviation is about 0.7; the exploration is 0.25.
    assert!((1.0..1.8).contains(&spread), "{spread}");
    assert_eq!((last.action_saturation["pull"], last.single_support), (0.0, None));
    let (dead, bonus, accuracy) =
        (last.dead_units.unwrap(), last.term_spread["bonus"], last.term_spread["accuracy"]);
    assert!(dead < 0.5 && bonus == 0.0 && accuracy > 0.01, "{dead} {bonus} {accuracy}");
}

#[test]
fn a_learning_rate_that_is_far_too_large_makes_the_policy_jump() {
    let (findings, lines) = trained(&settings(Rate::Constant(0.1)), None, Toy::new);
    let finding = of(&findings, "W0601");
    assert!(
        finding.message.contains("the policy jumps: update ")
            && finding.message.contains("times the target of 0.017"),
        "{finding:?}"
    );
    let first = lines.iter().find(|line| !line.warnings.is_empty()).unwrap();
    assert!(first.kl > 1.0 && first.samples == finding.since, "one update is enough: {}", first.kl);
}

#[test]
fn an_optimum_beyond_the_range_of_an_action_saturates_it() {
    let narrow = |optional: bool| {
        move || toy(|toy| toy.outputs = vec![Output { name: "pull".into(), range: [-0.05, 0.05], optional }])
    };
    let settings = Settings { std: vec![0.25], ..settings(Rate::Constant(3e-3)) };
    let (findings, _) = trained(&settings, None, narrow(false));
    let finding = of(&findings, "W0602");
    assert!(
        finding.subject == "pull" && finding.message.contains("action `pull` is saturated"),
        "{finding:?}"
    );
    assert_eq!(finding.until, None, "it is there to the end");
    assert!(
        !codes(&trained(&settings, None, narrow(true)).0).contains(&"W0602"),
        "an action that need not be used"
    );
}

#[test]
fn a_policy_that_gives_the_same_action_everywhere_is_dead_with_its_units() {
    let mut init = Network::orthogonal(&[2, 24, 24, 1], Activation::Relu, &mut Stream::new("test/health"));
    init.layers[1].bias.fill(-9.0);
    let (findings, lines) = trained(&settings(Rate::Constant(1e-4)), Some(&init), Toy::new);
    assert!(of(&findings, "W0603").message.contains("action `pull` is dead"), "{findings:?}");
    // All of the second hidden layer and some of the first.
    let share = lines[0].dead_units.unwrap();
    assert!((0.5..0.8).contains(&share) && of(&findings, "W0604").since == 300, "{share}: {findings:?}");
}

#[test]
fn a_critic_whose_steps_are_far_too_large_explains_nothing() {
    let settings = Settings { value_rate: 1.0, ..settings(Rate::Constant(1e-4)) };
    let (findings, lines) = trained(&settings, None, Toy::new);
    let finding = of(&findings, "W0605");
    assert!(finding.message.starts_with("the critic is useless: it explains "), "{finding:?}");
    // In the first updates after the warm-up the critic may be that wrong.
    assert_eq!(finding.since, lines[11].samples);
}

#[test]
fn a_term_that_never_pays_gives_no_signal() {
    let with_bonus = || toy(|toy| toy.ranges = [[-50.0, 1.0], [0.0, 10.0]]);
    let (findings, _) = trained(&settings(Rate::Constant(3e-4)), None, with_bonus);
    let finding = of(&findings, "W0607");
    assert_eq!(finding.subject, "bonus");
    assert_eq!(finding.message, "reward term `bonus` gives no signal: it is constantly zero");
    let ornament = || toy(|toy| toy.ranges = [[-50.0, 1.0], [0.0, 1.0]]);
    assert_eq!(codes(&trained(&settings(Rate::Constant(3e-4)), None, ornament).0), [""; 0]);
}

#[test]
fn a_kernel_that_is_too_flat_gives_no_signal_and_a_question_that_is_always_answered_with_yes_is_well() {
    let constant = |mean: f64, spread: f64| {
        move |metrics: &mut UpdateMetrics| {
            metrics.terms = BTreeMap::from([("accuracy".to_owned(), mean)]);
            metrics.term_spread = BTreeMap::from([("accuracy".to_owned(), spread)]);
        }
    };
    let flat = watched(30..100, constant(0.9995, 2e-4));
    assert_eq!(flat[0].message, "reward term `accuracy` gives no signal: it is constantly its full weight");
    let half = watched(30..100, constant(0.5, 2e-4));
    assert!(half[0].message.ends_with("constantly 50 % of its weight"), "{half:?}");
    assert_eq!(
        watched(30..100, constant(0.97, 4e-9)),
        [],
        "the feet of a squat are always on the ground; some robots fell"
    );
    assert_eq!(watched(30..100, constant(0.9, 0.01)), []);
}

#[test]
fn returns_beyond_what_the_rewards_allow_are_told() {
    let stingy = || toy(|toy| toy.ranges = [[0.0, 0.1], [0.0, 0.0]]);
    let (findings, _) = trained(&settings(Rate::Constant(3e-4)), None, stingy);
    let finding = of(&findings, "W0608");
    // Rewards up to 0.1, scaled by 0.1, discounted by 0.9.
    assert!(
        finding.message.contains("targets are out of range")
            && finding.message.ends_with("allow 0.000 to 0.10"),
        "{finding:?}"
    );
}

/// Metrics of a healthy walk.
fn walking(update: u64) -> UpdateMetrics {
    let named = |value: f64| BTreeMap::from([("pull".to_owned(), value)]);
    UpdateMetrics {
        update,
        samples: 1000 * (update + 1),
        length_mean_s: Some(8.0),
        kl: 0.02,
        explained_variance: 0.9,
        term_spread: BTreeMap::from([("accuracy".to_owned(), 0.2)]),
        action_saturation: named(0.1),
        action_spread: named(2.0),
        dead_units: Some(0.1),
        single_support: Some(0.6),
        reference_single_support: Some(0.64),
        target_min: Some(0.0),
        target_max: Some(0.6),
        value_min: Some(-0.1),
        value_max: Some(0.7),
        ..UpdateMetrics::default()
    }
}

fn monitor() -> Monitor {
    let toy = toy(|toy| toy.ranges = [[0.0, 1.0], [0.0, 0.0]]);
    Monitor::new(Norms::new(&toy::settings(), &toy))
}

/// The findings after these updates of a long training are changed.
fn watched(updates: std::ops::Range<u64>, change: impl Fn(&mut UpdateMetrics)) -> Vec<Finding> {
    let mut monitor = monitor();
    for update in 0..100 {
        let mut metrics = walking(update);
        if updates.contains(&update) {
            change(&mut metrics);
        }
        monitor.observe(&metrics);
    }
    monitor.findings().to_vec()
}

#[test]
fn a_single_episode_whose_physics_diverges_is_told() {
    let findings = watched(40..41, |metrics| {
        metrics.episodes = 12;
        metrics.ends = BTreeMap::from([("exploded".to_owned(), 3), ("time_out".to_owned(), 9)]);
    });
    assert_eq!(codes(&findings), ["W0610"]);
    assert_eq!(findings[0].message, "the physics diverged in 3 of 12 episodes that ended in update 40");
}

#[test]
fn a_robot_that_stands_where_it_should_step_is_told() {
    let still = |metrics: &mut UpdateMetrics| metrics.single_support = Some(0.01);
    let findings = watched(50..100, still);
    let message = "the robot does not step: it is on one foot in 1.0 % of the steps, the reference in 64 %";
    let expected = Finding {
        code: "W0606".into(),
        subject: String::new(),
        message: message.into(),
        since: 51_000,
        until: None,
    };
    assert_eq!(findings, [expected]);
    let no_end =
        |metrics: &mut UpdateMetrics| (metrics.single_support, metrics.length_mean_s) = (Some(0.01), None);
    assert_eq!(codes(&watched(50..100, no_end)), ["W0606"], "no episode ended: they are long");
    let falling = |metrics: &mut UpdateMetrics| {
        (metrics.single_support, metrics.length_mean_s) = (Some(0.01), Some(0.7))
    };
    assert_eq!(watched(50..100, falling), [], "a robot that falls at once has other troubles");
    let standing = |metrics: &mut UpdateMetrics| {
        (metrics.single_support, metrics.reference_single_support) = (Some(0.0), Some(0.0));
    };
    assert_eq!(watched(0..100, standing), [], "the reference stands, too");
}

#[test]
fn values_far_outside_of_their_targets_are_told() {
    let wild = |metrics: &mut UpdateMetrics| metrics.value_max = Some(1.3);
    let findings = watched(30..100, wild);
    let message = "the critic's values are out of range: -0.10 to 1.30, while its targets are 0.000 to 0.60";
    assert_eq!((findings[0].code.as_str(), findings[0].message.as_str()), ("W0608", message));
    assert_eq!(watched(30..100, |metrics| metrics.value_max = Some(1.1)), []);
}

#[test]
fn a_sign_must_stay_and_is_told_once_with_its_end() {
    let worse = |metrics: &mut UpdateMetrics| metrics.explained_variance = -0.1;
    assert_eq!(watched(50..59, worse), [], "nine updates are chance");
    let findings = watched(50..60, worse);
    assert_eq!(
        (codes(&findings), findings[0].since, findings[0].until),
        (vec!["W0605"], 51_000, Some(60_000))
    );
    let mut twice = monitor();
    let mut told = 0;
    for update in 0..100 {
        let mut metrics = walking(update);
        if (20..40).contains(&update) || (70..100).contains(&update) {
            worse(&mut metrics);
        }
        told += twice.observe(&metrics).len();
    }
    assert_eq!(
        (told, twice.findings()[0].since, twice.findings()[0].until),
        (1, 21_000, None),
        "it came back"
    );
}

#[test]
fn the_kl_divergence_may_be_large_for_a_moment_but_not_for_long() {
    let kl = |value: f64| move |metrics: &mut UpdateMetrics| metrics.kl = value;
    assert_eq!(watched(10..14, kl(0.11)), [], "four updates at five times the target");
    assert_eq!(codes(&watched(10..15, kl(0.11))), ["W0601"]);
    assert_eq!(watched(0..100, kl(0.1)), [], "the target is 0.02");
    let once = watched(10..11, kl(1.5));
    assert_eq!((once[0].since, once[0].until), (11_000, Some(11_000)));
    assert_eq!(
        once[0].message,
        "the policy jumps: update 10 moved it by a KL divergence of 1.50, 75 times the target of 0.020"
    );
    assert_eq!(codes(&watched(10..11, kl(f64::NAN))), ["W0601"]);
}

#[test]
fn the_lines_of_an_earlier_version_are_read_and_find_only_what_they_hold() {
    let line = r#"{"update":30,"samples":31000,"samples_total":99000,"simulated_s":1.0,"wall_s":1.0,"cpu_s":1.0,
        "learner_cpu_s":1.0,"samples_per_s":1.0,"episodes":0,"return_mean":null,"length_mean_s":null,"reward_mean":1.0,
        "terms":{"accuracy":0.5},"ends":{},"kl":7.0,"clip_fraction":0.1,"explained_variance":0.5,"value_loss":0.1,
        "learning_rate":1e-4,"epochs":3,"actor_gradient_norm":1.0,"critic_gradient_norm":1.0}"#;
    let metrics: UpdateMetrics = serde_json::from_str(line).unwrap();
    let mut monitor = monitor();
    for _ in 0..20 {
        monitor.observe(&metrics);
    }
    assert_eq!(codes(monitor.findings()), ["W0601"]);
}

#[test]
fn every_finding_has_a_page_and_a_cure() {
    for rule in super::rules::RULES {
        assert!(crate::diag::codes::page(rule.code).is_some(), "{}", rule.code);
        assert_ne!(cure(rule.code), cure(""), "{}", rule.code);
    }
}
