//! Run-time checks at the command line: a real training that goes wrong says so while it runs, in its files
//! and in its report; a spec can mean it.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A training of some seconds whose first update of the actor destroys the policy.
const WILD: &[&str] = &[
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=1024",
    "learn.rollout=256",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "learn.learning_rate=0.1",
    "evaluate.nominal.episodes=1",
    "evaluate.nominal.time_limit=\"0.2 s\"",
    "deploy.mujoco.episodes=1",
];

/// The spec in a folder, with more lines.
fn spec(folder: &Path, more: &str) -> PathBuf {
    let parent = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/tocabi_walk_torque.toml");
    let path = folder.join("wild.toml");
    let text = format!(
        "spec = 1\nname = \"wild\"\nsummary = \"A step that is far too large\"\nextends = \
         \"{}\"\n[report]\ncompare = []\n{more}",
        parent.display()
    );
    std::fs::write(&path, text).unwrap();
    path
}

fn run(spec: &Path, store: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.env("OMP_NUM_THREADS", "1").arg("--store").arg(store).arg("run").arg(spec);
    command.arg("--allow-outside").arg(concat!(env!("CARGO_MANIFEST_DIR"), "/specs"));
    command.args(["--profile", "quick", "--jobs", "2", "--reports"]).arg(store.join("reports"));
    let output =
        command.args(WILD.iter().flat_map(|assignment| ["--set", assignment])).args(more).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// The one entry of a folder.
fn only(folder: &Path) -> PathBuf {
    let entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
    entries[0].clone()
}

fn warnings(events: &[u8]) -> Vec<serde_json::Value> {
    let events = String::from_utf8_lossy(events);
    let events = events.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    events.filter(|event| event["event"] == "warning").collect()
}

#[test]
fn a_training_that_jumps_says_so_in_events_files_and_report_unless_the_spec_means_it() {
    let folder = tempfile::tempdir().unwrap();
    let plain = spec(folder.path(), "");
    let store = folder.path().join("store");

    let told = warnings(&run(&plain, &store, &["--format", "json"]).stdout);
    let warning = told.iter().find(|warning| warning["code"] == "W0601").expect("the jump is told");
    assert_eq!(warning["stage"], "learner");
    assert!(
        warning["message"].as_str().unwrap().starts_with("the policy jumps: update 1 moved it"),
        "{warning}"
    );
    assert!(warning["help"].as_str().unwrap().contains("`specforge explain W0601`"), "{warning}");

    let learner = only(&store.join("learner"));
    let lines = std::fs::read_to_string(learner.join("metrics.jsonl")).unwrap();
    let second: serde_json::Value = serde_json::from_str(lines.lines().nth(1).unwrap()).unwrap();
    assert_eq!(second["warnings"][0]["code"], "W0601");
    let summary = std::fs::read_to_string(learner.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(
        (&summary["warnings"][0]["code"], &summary["warnings"][0]["since"]),
        (&"W0601".into(), &512.into())
    );

    let report = std::fs::read_to_string(store.join("reports/wild.md")).unwrap();
    let row = report.lines().find(|line| line.contains("| `W0601` |")).expect("the report has the warning");
    assert!(row.contains("| 512 | the end |") && row.contains("lower `learn.learning_rate`"), "{row}");

    // The learner is the same; only the report is another.
    let meant = spec(folder.path(), "[allow]\nW0601 = \"a test\"\n");
    let again = run(&meant, &store, &["--format", "json"]);
    assert!(String::from_utf8_lossy(&again.stdout).contains("\"worked\":1"));
    let report = std::fs::read_to_string(store.join("reports/wild.md")).unwrap();
    assert!(!report.contains("| `W0601` |"), "{report}");
    assert!(report.contains("wild: `W0601` was found and is allowed by the spec: a test."), "{report}");

    let fresh = folder.path().join("fresh");
    let output = run(&meant, &fresh, &["--until", "learner"]);
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!log.contains("W0601") && log.contains("done in"), "{log}");
}

/// An impulse that no simulation survives, before the policy of this training can fall.
#[test]
fn an_evaluation_that_diverges_is_told_with_its_first_episode_and_does_not_fail() {
    let folder = tempfile::tempdir().unwrap();
    // The largest impulse that the key takes moves a robot of half of TOCABI's mass faster than 1000 m/s.
    let push = "[evaluate.nominal.randomize.push]\nimpulse = \"1e5 N*s\"\nduration = \"1 ms\"\n\
                at = \"0.02 s\"\n[evaluate.nominal.randomize.link_mass]\nscale = 0.5\n";
    let output = run(&spec(folder.path(), push), &folder.path().join("store"), &["--format", "json"]);
    let told = warnings(&output.stdout);
    let warning = told.iter().find(|warning| warning["code"] == "R0001").expect("the divergence is told");
    assert_eq!(warning["stage"], "evaluate.nominal");
    let expected = "the physics diverged in 1 of 1 episodes, first in `1000/evaluate/episode/0`";
    assert_eq!(warning["message"], expected);
}
