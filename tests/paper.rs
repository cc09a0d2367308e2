//! The paper in the specs: what `docs/explanation/paper.md` says we read and by which keys, and the numbers
//! that the paper prints, typed here from its text and not from the specs.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};
use specforge::check::checked;
use specforge::env::Blueprint;
use specforge::kinds::keys::keys;
use specforge::kinds::motion::shipped;
use specforge::kinds::terminate;
use specforge::spec::LoadOptions;
use specforge::spec::value::canonical_table;

fn path(file: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// The rows of the table of readings, cell by cell, without its head.
fn readings() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path("docs/explanation/paper.md")).expect("the page is there");
    let rows = text.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
    rows.skip(1).map(|row| row.split(" | ").map(str::to_owned).collect()).collect()
}

/// The questions of a row: `A8, A9` and `A41-A46` are several, `-` is none.
fn questions(cell: &str) -> Vec<u32> {
    let number = |word: &str| word.strip_prefix('A').and_then(|digits| digits.parse::<u32>().ok());
    let several = |word: &str| match word.split_once('-') {
        Some((first, last)) => Some(number(first)?..=number(last)?),
        None => number(word).map(|only| only..=only),
    };
    cell.split(", ").filter_map(several).flatten().collect()
}

/// The dotted keys among what stands in backticks.
fn quoted_keys(cell: &str) -> Vec<&str> {
    let quoted = cell.split('`').skip(1).step_by(2);
    let dotted =
        |word: &&str| word.contains('.') && word.chars().all(|c| c.is_ascii_lowercase() || "._".contains(c));
    quoted.filter(dotted).collect()
}

/// Whether the language has this key, or keys below it, or a termination of this name, which may have none.
fn is_known(word: &str) -> bool {
    let below = format!("{word}.");
    let named =
        word.strip_prefix("terminate.").is_some_and(|name| terminate::kinds().iter().any(|k| k.name == name));
    named || keys().iter().any(|key| key.path == word || key.path.starts_with(&below))
}

#[test]
fn every_question_of_the_paper_has_a_reading() {
    let rows = readings();
    assert!(
        rows.iter().all(|row| row.len() == 4 && row.iter().all(|cell| !cell.trim().is_empty())),
        "{rows:#?}"
    );
    let answered: BTreeSet<u32> = rows.iter().flat_map(|row| questions(&row[0])).collect();
    let open: Vec<u32> = (1..=32).filter(|question| !answered.contains(question)).collect();
    assert!(open.is_empty(), "without a reading: {open:?}");
}

#[test]
fn every_key_that_a_reading_names_is_one_of_the_language() {
    let rows = readings();
    let named: BTreeSet<&str> = rows.iter().flatten().flat_map(|cell| quoted_keys(cell)).collect();
    assert!(named.len() > 20 && named.contains("learn.time_limit"), "{named:?}");
    let unknown: Vec<_> = named.into_iter().filter(|word| !is_known(word)).collect();
    assert!(unknown.is_empty(), "no keys of the language: {unknown:?}");
    assert!(!is_known("learn.time_limits") && !is_known("reward.velocity"), "a renamed key is seen");
}

/// The paper's torque walk as it is resolved, in SI units.
fn walk() -> (Value, Blueprint) {
    let checked = checked(&path("specs/paper/baseline.toml"), &LoadOptions::default());
    let (experiment, robot) = checked.sound().expect("the spec is sound");
    let motion = shipped("walk", robot).expect("it comes with the program").expect("it suits TOCABI");
    let blueprint = Blueprint::new(experiment.table.clone(), robot.clone(), Some(motion)).expect("it fits");
    (canonical_table(&experiment.table), blueprint)
}

/// What the paper prints, by the key that says it.
fn printed() -> Vec<(&'static str, Value)> {
    let share = json!({ "uniform": [0.6, 1.4] });
    vec![
        // III: the control loop and the action.
        ("physics.rate", json!(2000.0)),
        ("action.rate", json!(250.0)),
        ("action.kind", json!("torque")),
        ("action.std", json!(0.1)),
        ("action.delay", json!(0.004)),
        ("task.episode", json!(16.0)),
        // Eq. (2): the encoders.
        ("observe.joint_position.noise", json!({ "normal": [0.0, 1e-4] })),
        ("observe.joint_velocity.low_pass", json!(4.0)),
        // Table I.
        ("reward.base_orientation.weight", json!(0.3)),
        ("reward.base_orientation.k", json!(13.2)),
        ("reward.joint_tracking.weight", json!(0.35)),
        ("reward.joint_tracking.k", json!(4.0)),
        ("reward.contact_schedule.weight", json!(0.2)),
        ("reward.velocity_tracking.weight", json!(0.3)),
        ("reward.velocity_tracking.k", json!(3.0)),
        ("reward.joint_velocity.weight", json!(0.05)),
        ("reward.joint_velocity.k", json!(0.01)),
        ("reward.joint_velocity_change.weight", json!(0.05)),
        ("reward.joint_velocity_change.k", json!(20.0)),
        ("reward.contact_force.weight", json!(0.1)),
        ("reward.contact_force.k", json!(0.0005)),
        ("reward.contact_force_change.weight", json!(0.1)),
        ("reward.contact_force_change.k", json!(0.0005)),
        ("reward.torque.weight", json!(0.05)),
        ("reward.torque.k", json!(0.01)),
        ("reward.torque_change.weight", json!(0.2)),
        ("reward.torque_change.k", json!(0.01)),
        // Table II.
        ("randomize.link_mass.scale", share.clone()),
        ("randomize.link_inertia.scale", share.clone()),
        ("randomize.link_com.scale", share.clone()),
        ("randomize.joint_damping.scale", share.clone()),
        ("randomize.joint_friction.scale", share),
        ("randomize.motor_constant.scale", json!({ "uniform": [1.0, 1.1] })),
        ("randomize.action_delay.scale", json!({ "uniform": [0.5, 1.5] })),
        // The training, and from its authors' code what it does not print.
        ("pretrain.kind", json!("gravity_compensation")),
        ("pretrain.samples", json!(200_000)),
        ("learn.samples", json!(80_000_000)),
        ("learn.rollout", json!(16_384)),
        ("learn.minibatch", json!(128)),
        ("learn.learning_rate.linear", json!([5e-5, 1e-6])),
        ("learn.policy.hidden", json!([256.0, 256.0])),
        ("learn.policy.activation", json!("relu")),
        ("learn.value.hidden", json!([256.0, 256.0])),
        ("learn.value.activation", json!("relu")),
        ("learn.environments", json!(8)),
        ("learn.epochs", json!(3)),
        ("learn.gamma", json!(0.99)),
        ("learn.lambda", json!(0.95)),
        ("learn.clip", json!(0.2)),
        ("learn.max_grad_norm", json!(0.5)),
        ("learn.value.learning_rate", json!(5e-4)),
    ]
}

/// Whether two values mean the same: 256 and 256.0 are one number.
fn same(found: &Value, printed: &Value) -> bool {
    match (found, printed) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|number| number.as_f64().expect("a number"));
            (a - b).abs() <= 1e-12 * b.abs()
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && b.iter().all(|(key, b)| a.get(key).is_some_and(|a| same(a, b)))
        }
        _ => found == printed,
    }
}

#[test]
fn the_baseline_says_what_the_paper_prints() {
    let (resolved, _) = walk();
    for (key, expected) in printed() {
        let found = resolved.pointer(&format!("/{}", key.replace('.', "/"))).unwrap_or(&Value::Null);
        assert!(same(found, &expected), "`{key}` is {found}, the paper has {expected}");
    }
}

#[test]
fn the_paper_has_ten_terms_seven_rows_of_randomization_and_4883_updates() {
    let (resolved, blueprint) = walk();
    let table = |name: &str| resolved[name].as_object().expect("a table").clone();
    assert_eq!((table("reward").len(), table("randomize").len()), (10, 7));
    let most: f64 = table("reward").values().map(|term| term["weight"].as_f64().expect("a number")).sum();
    assert!((most - 1.70).abs() < 1e-12, "at most {most} per step");
    let [samples, rollout] =
        ["samples", "rollout"].map(|key| resolved["learn"][key].as_u64().expect("a count"));
    assert_eq!(samples.div_ceil(rollout), 4883);
    let sizes = blueprint.sizes();
    assert_eq!((sizes.observation, sizes.action), (30, 13));
}

/// A committed spec as the profile `paper` resolves it, in SI units.
fn resolved(spec: &str) -> Value {
    let options = LoadOptions { profile: Some("paper".into()), ..LoadOptions::default() };
    let checked = checked(&path(&format!("specs/{spec}.toml")), &options);
    let (experiment, _) = checked.sound().unwrap_or_else(|| panic!("{spec}: {:#?}", checked.sink));
    canonical_table(&experiment.table)
}

#[test]
fn the_profile_paper_trains_in_the_batch_engine_and_is_judged_in_mujoco_at_the_same_rate() {
    for spec in [
        "tocabi_walk_torque",
        "tocabi_walk_position",
        "tocabi_squat_torque",
        "atlas_walk_torque",
        "tocabi_run_position",
    ] {
        let spec = resolved(spec);
        assert_eq!(spec["physics"], json!({ "engine": "batch", "rate": 2000.0 }));
        assert_eq!(
            (&spec["deploy"]["mujoco"]["engine"], &spec["deploy"]["mujoco"]["rate"]),
            (&json!("mujoco"), &json!(2000.0))
        );
    }
}

#[test]
fn episodes_of_the_profile_paper_begin_and_end_as_those_of_the_authors() {
    let height = |spec: &str| resolved(spec)["terminate"]["base_height"]["below"].as_f64().expect("a height");
    let heights = [
        ("tocabi_walk_torque", 0.6),
        ("tocabi_run_torque", 0.6),
        ("tocabi_squat_position", 0.6),
        ("atlas_walk_position", 0.5),
        ("atlas_run_position", 0.7),
    ];
    for (spec, below) in heights {
        assert!((height(spec) - below).abs() < 1e-12, "{spec}");
    }
    assert!(same(&resolved("tocabi_walk_torque")["initial"]["phases"], &json!([0.0, 0.5])));
    assert!(same(&resolved("tocabi_run_torque")["initial"]["phases"], &json!([0.125, 0.625])));
    let squat = resolved("tocabi_squat_torque");
    assert_eq!(
        (&squat["initial"]["kind"], &squat["initial"]["velocities"]),
        (&json!("reference"), &json!("rest"))
    );
    let tilt = squat["terminate"]["base_tilt"]["above"].as_f64().expect("an angle");
    assert!((tilt - 30.0_f64.to_radians()).abs() < 1e-9, "{tilt}");
}
