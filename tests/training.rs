//! Real trainings, small ones, through the command line: the whole pipeline, kill and resume, interruption.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod sets;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

const SPEC: &str = "specs/tocabi_walk_torque.toml";

/// A training of some seconds: 8 updates of 256 samples, a checkpoint after each.
const SMALL: &[&str] = &[
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=2048",
    "learn.rollout=256",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "learn.checkpoint_every=1",
    "evaluate.nominal.episodes=2",
    "evaluate.nominal.time_limit=\"1 s\"",
    "deploy.mujoco.episodes=2",
    "deploy.rapier.episodes=2",
];

const BATCH: &[&str] = &["--set", "physics.engine=\"batch\""];
const RAPIER: &[&str] = &["--set", "physics.engine=\"rapier\""];

fn specforge(store: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("--store").arg(store).env("OMP_NUM_THREADS", "1");
    command
}

fn run(store: &Path, jobs: &str, more: &[&str]) -> Command {
    let mut command = specforge(store);
    command.args(["run", SPEC, "--profile", "quick", "--jobs", jobs]);
    command.args(sets::usual(SMALL, more)).args(more);
    command.arg("--reports").arg(store.join("reports")).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

const LEARNER: &[&str] = &["--until", "tocabi_walk_torque/learner"];

/// Runs to the end of the learner and gives the policy's bytes.
fn policy(store: &Path, jobs: &str) -> Vec<u8> {
    policy_with(store, jobs, &[])
}

/// The same with further options.
fn policy_with(store: &Path, jobs: &str, more: &[&str]) -> Vec<u8> {
    let output = run(store, jobs, &[LEARNER, more].concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(only(&store.join("learner")).join("actor.safetensors")).unwrap()
}

/// The one entry of a folder.
fn only(folder: &Path) -> PathBuf {
    let entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
    entries[0].clone()
}

/// Waits until the training has written a checkpoint.
fn wait_for_checkpoint(store: &Path, child: &mut Child) {
    let start = Instant::now();
    let written = || {
        let folders = std::fs::read_dir(store.join("scratch")).into_iter().flatten().flatten();
        let mut files =
            folders.flat_map(|folder| std::fs::read_dir(folder.path()).into_iter().flatten().flatten());
        files.any(|file| file.file_name().to_string_lossy().starts_with("checkpoint"))
    };
    while !written() {
        assert!(child.try_wait().unwrap().is_none(), "the training ended before it was stopped");
        assert!(start.elapsed() < Duration::from_secs(300), "no checkpoint was written");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

#[test]
fn a_training_that_was_killed_goes_on_to_the_same_bits_with_one_and_two_threads() {
    for engine in [BATCH, RAPIER] {
        let whole = tempfile::tempdir().unwrap();
        let expected = policy_with(whole.path(), "1", engine);
        for (before, after) in [("1", "2"), ("2", "1")] {
            let store = tempfile::tempdir().unwrap();
            let words = [LEARNER, engine].concat();
            let mut child = run(store.path(), before, &words).stderr(Stdio::null()).spawn().unwrap();
            wait_for_checkpoint(store.path(), &mut child);
            signal(&child, Signal::KILL);
            child.wait().unwrap();
            assert!(!store.path().join("learner").exists(), "the training was over before it was killed");
            let found = policy_with(store.path(), after, engine);
            assert_eq!(found, expected, "{engine:?}: killed with {before}, resumed with {after} threads");
        }
    }
}

#[test]
fn an_interrupted_training_exits_with_6_and_goes_on_to_the_same_bits() {
    let whole = tempfile::tempdir().unwrap();
    let expected = policy(whole.path(), "2");
    let store = tempfile::tempdir().unwrap();
    let mut child = run(store.path(), "2", LEARNER).stderr(Stdio::null()).spawn().unwrap();
    wait_for_checkpoint(store.path(), &mut child);
    signal(&child, Signal::INT);
    assert_eq!(child.wait().unwrap().code(), Some(6));
    // It is the same training, however often it writes a checkpoint.
    assert_eq!(policy_with(store.path(), "2", &["--set", "learn.checkpoint_every=3"]), expected);
}

#[test]
fn the_whole_pipeline_reports_both_arms_and_a_second_run_does_nothing() {
    let store = tempfile::tempdir().unwrap();
    let output = run(store.path(), "2", &[]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let path = String::from_utf8(output.stdout).unwrap();
    let report = std::fs::read_to_string(path.trim()).unwrap();
    for words in ["**torque**", "**position**", "In batch", "In rapier", "In mujoco", "below the baseline's"]
    {
        assert!(report.contains(words), "the report lacks `{words}`");
    }
    let again = run(store.path(), "2", &["--format", "json"]).output().unwrap();
    let last: serde_json::Value = serde_json::from_slice(
        again.stdout.split(|&byte| byte == b'\n').rev().find(|line| !line.is_empty()).unwrap(),
    )
    .unwrap();
    assert_eq!(
        (&last["event"], &last["outcome"], &last["worked"]),
        (&"run_finished".into(), &"ok".into(), &0.into())
    );

    let mut dry = run(store.path(), "2", &["--dry-run", "--set", "reward.torque.weight=0.06"]);
    let stages = String::from_utf8(dry.output().unwrap().stdout).unwrap();
    assert!(stages.contains("learner") && stages.contains("deploy.mujoco"), "{stages}");
    assert!(!stages.contains("pretrain"), "{stages}");
}

/// Trained in MuJoCo, transferred to rapier.
const THE_OTHER_WAY: &[&str] =
    &["--set", "physics.engine=\"mujoco\"", "--set", "deploy.mujoco.engine=\"rapier\""];

#[test]
fn a_training_has_the_same_bits_whatever_the_number_of_threads() {
    let policies = [THE_OTHER_WAY, BATCH].map(|engine| {
        let of = |jobs| policy_with(tempfile::tempdir().unwrap().path(), jobs, engine);
        let policies = ["1", "2", "3"].map(of);
        assert!(policies.iter().all(|policy| *policy == policies[0]), "{engine:?}");
        policies[0].clone()
    });
    assert_ne!(policies[0], policies[1], "the engine makes no difference");
}

#[test]
fn a_policy_of_mujoco_is_evaluated_there_and_transferred_to_rapier() {
    let store = tempfile::tempdir().unwrap();
    let output = run(store.path(), "2", THE_OTHER_WAY).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = std::fs::read_to_string(String::from_utf8(output.stdout).unwrap().trim()).unwrap();
    for words in ["In mujoco", "In rapier"] {
        assert!(report.contains(words), "the report lacks `{words}`");
    }
}

#[test]
fn a_run_without_samples_evaluates_the_pre_trained_network_alone() {
    let store = tempfile::tempdir().unwrap();
    let until = ["--until", "tocabi_walk_torque/evaluate.nominal", "--until", "report"];
    let output =
        run(store.path(), "2", &[&["--set", "learn.samples=0"][..], &until].concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let actors: Vec<Vec<u8>> = ["pretrain", "learner"]
        .iter()
        .flat_map(|stage| std::fs::read_dir(store.path().join(stage)).unwrap())
        .map(|entry| std::fs::read(entry.unwrap().path().join("actor.safetensors")).unwrap())
        .collect();
    // Both arms: a pre-trained actor each, and it is the policy.
    assert_eq!(actors.len(), 4);
    assert!((0..2).all(|arm| actors[2..].contains(&actors[arm])) && actors[0] != actors[1]);
    let report = std::fs::read_to_string(String::from_utf8(output.stdout).unwrap().trim()).unwrap();
    assert!(
        report.contains("this is the pre-trained network alone") && report.contains("on held-out states")
    );
}
