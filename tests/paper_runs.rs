//! The runs of the paper's own setting take weeks and go on beside all other work, so their recipes and the
//! bits of their trainings stay as they are.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod folders;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use self::folders::copy;
use serde_json::{Value as Json, json};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn golden(name: &str) -> PathBuf {
    root().join("tests/golden").join(name)
}

/// The golden file, after it was written if SPECFORGE_BLESS is set.
fn known(name: &str, found: &Json) -> Json {
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(golden(name), serde_json::to_string_pretty(found).unwrap() + "\n").unwrap();
    }
    serde_json::from_str(&fs::read_to_string(golden(name)).expect("the golden file")).expect("JSON")
}

/// The suites of the list in their order, each once, with their profiles.
fn rows() -> Vec<(String, String)> {
    let list = fs::read_to_string(root().join("tools/paper-runs.toml")).expect("the list of the runs");
    let list: toml::Table = list.parse().expect("TOML");
    let text = |row: &toml::Value, key: &str| row[key].as_str().expect("a text").to_owned();
    let rows = list["row"].as_array().expect("rows");
    rows.iter().map(|row| (text(row, "suite"), text(row, "profile"))).collect()
}

/// The trainings of a suite by run: each stage's name and fingerprint.
fn trainings(suite: &str, profile: &str, folder: &Path) -> BTreeMap<String, BTreeMap<String, String>> {
    let path = folder.join("plan.json");
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(root()).args(["plan", suite, "--profile", profile, "--save"]).arg(&path);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{suite}: {}", String::from_utf8_lossy(&output.stderr));
    let plan: Json = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let arms = plan["arms"].as_array().expect("arms");
    let of_arm = |arm: &Json| {
        let own = |name: &str| Some((name.to_owned(), arm["stages"].get(name)?.as_str()?.to_owned()));
        let stages = ["pretrain", "learner", "fine_tune"].into_iter().filter_map(own).collect();
        (arm["name"].as_str().expect("a name").to_owned(), stages)
    };
    arms.iter().map(of_arm).collect()
}

#[test]
fn the_trainings_of_the_papers_runs_have_the_fingerprints_that_they_were_started_with() {
    let folder = tempfile::tempdir().unwrap();
    let found: BTreeMap<String, _> = rows()
        .into_iter()
        .map(|(suite, profile)| {
            let name = Path::new(&suite).file_stem().expect("a name").to_string_lossy().into_owned();
            (name, trainings(&suite, &profile, folder.path()))
        })
        .collect();
    assert!(found.len() > 8, "{:?}", found.keys());
    let found = json!(found);
    let known = known("paper_fingerprints.json", &found);
    let differing: Vec<String> = known
        .as_object()
        .expect("suites")
        .iter()
        .flat_map(|(suite, runs)| {
            let differs = |(run, stages): &(&String, &Json)| found[suite][run.as_str()] != **stages;
            let of_suite = runs.as_object().expect("runs").iter().filter(differs);
            of_suite.map(move |(run, _)| format!("{suite}: {run}")).collect::<Vec<_>>()
        })
        .collect();
    let advice = "the recipe of a run of the paper has changed, so that the run would begin again; a new key \
        needs a default that \
                  gives the old behaviour";
    assert_eq!(differing, Vec::<String>::new(), "{advice}");
    assert_eq!(found, known, "a new run is written to the golden file with SPECFORGE_BLESS=1");
}

/// Trains the first 20 000 samples (two updates) of a run of the paper, and gives the digests of its
/// networks.
fn first_samples(suite: &str, run: &str, folder: &Path) -> Json {
    let store = folder.join(run.replace(['=', ',', ' ', '%'], "_"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(root()).arg("--store").arg(&store).env("OMP_NUM_THREADS", "1");
    command.args(["run", suite, "--profile", "paper", "--set", "learn.stop_at=20000", "--jobs", "2"]);
    command.args(["--until", &format!("{run}/learner")]).arg("--reports").arg(store.join("reports"));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{run}: {}", String::from_utf8_lossy(&output.stderr));
    let learners: Vec<_> =
        fs::read_dir(store.join("learner")).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(learners.len(), 1);
    let digest = |name: &str| {
        let bytes = fs::read(learners[0].join(format!("{name}.safetensors"))).unwrap();
        blake3::hash(&bytes).to_hex().to_string()
    };
    json!({ "actor": digest("actor"), "critic": digest("critic") })
}

/// Compares with the digests of the golden file, which are of a processor with AVX2.
fn has_the_bits_of(name: &str, run: &str) {
    let folder = tempfile::tempdir().unwrap();
    let found = first_samples("specs/paper/paper_pretraining.toml", run, folder.path());
    assert_eq!(found, known(name, &found), "the physics or the learner have other numbers");
}

#[test]
fn the_first_samples_of_a_torque_run_have_the_same_bits_everywhere() {
    has_the_bits_of("paper_policy_torque.json", "task=walk,control=torque_from_scratch,seed=1");
}

#[test]
fn the_first_samples_of_a_position_run_have_the_same_bits_everywhere() {
    has_the_bits_of("paper_policy_position.json", "task=walk,control=position,seed=1");
}

#[test]
fn the_hours_that_remain_count_a_sample_by_its_engine() {
    let home = tempfile::tempdir().unwrap();
    let (project, clone) = (home.path().join("project"), home.path().join("clone"));
    // Without `reports`: the records there are of runs that are done.
    for folder in ["specs", "robots"] {
        copy(&root().join(folder), &project.join(folder));
        copy(&root().join(folder), &clone.join(folder));
    }
    copy(&root().join("tools"), &project.join("tools"));
    let program = clone.join("target/release/specforge");
    fs::create_dir_all(program.parent().unwrap()).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_specforge"), &program).unwrap();
    let mut command = Command::new(project.join("tools/paper-runs"));
    command.args(["--list", "tools/engine-runs.toml", "--status", "--home"]).arg(home.path());
    let output = command.current_dir(&project).output().expect("Python 3");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    // In each engine 6 walks of 4 M and 12 others of 5 M samples: 84 M * (53 + 113 + 255) us.
    assert!(
        text.contains("specs/studies/engines.toml: 0 of 54 runs, 9.8 core-hours of training to go"),
        "{text}"
    );
    assert!(
        text.contains("53 us a sample in batch, 113 us a sample in mujoco, 255 us a sample in rapier"),
        "{text}"
    );
}
