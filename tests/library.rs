//! The example of `examples/`: a program that checks, plans, runs and reports without the command line.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

mod folders;

#[path = "../examples/study.rs"]
mod study;

use std::fs;
use std::path::Path;

use self::folders::copy;
use specforge::spec::LoadOptions;

/// A training of some seconds.
const SMALL: &[&str] = &[
    "physics.engine=\"rapier\"",
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=512",
    "learn.rollout=256",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "evaluate.nominal.episodes=3",
    "evaluate.nominal.time_limit=\"1 s\"",
];

#[test]
fn a_program_checks_plans_runs_and_reports() {
    let project = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    ["specs", "robots"].iter().for_each(|folder| copy(&root.join(folder), &project.path().join(folder)));
    let spec = project.path().join("specs/tocabi_squat_torque.toml");
    let sets = SMALL.iter().map(|set| (*set).to_owned()).chain(["report.compare=[]".to_owned()]).collect();
    let options = LoadOptions { profile: Some("quick".to_owned()), sets, ..LoadOptions::default() };
    let page = study::report(&spec, &options).unwrap().expect("every stage is done");
    assert_eq!(page, project.path().join("reports/tocabi_squat_torque.md"));
    assert!(fs::read_to_string(&page).unwrap().starts_with("# "));

    let wrong = LoadOptions { sets: vec!["learn.sample=1".to_owned()], ..LoadOptions::default() };
    assert_eq!(study::report(&spec, &wrong).unwrap_err().to_string(), "the specs have errors");
}
