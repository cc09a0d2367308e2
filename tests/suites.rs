//! Suites from their file to the plan: which runs there are, what they share, and what a change leaves alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use specforge::check;
use specforge::spec::LoadOptions;

/// A folder with a suite beside a complete spec.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(suite: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
        let whole = fs::read_to_string(whole).expect("whole.toml is readable");
        let deploy = "[pretrain]\nkind = \"gravity_compensation\"\nsamples = \"200 \
            k\"\n[deploy.policy]\nkind = \"export\"\n";
        fs::write(folder.path().join("whole.toml"), whole + deploy).expect("written");
        let folder = Self(folder);
        folder.write(suite);
        folder
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("suite.toml")
    }

    fn write(&self, suite: &str) {
        fs::write(self.path(), suite).expect("written");
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(self.0.path()).args(arguments).args(["--store", "store"]);
        command
    }

    fn text(&self, arguments: &[&str]) -> String {
        let output = self.command(arguments).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    }

    /// The plan that `plan --save` writes.
    fn plan(&self) -> Value {
        self.text(&["plan", "suite.toml", "--save", "plan.json"]);
        let text = fs::read_to_string(self.0.path().join("plan.json")).expect("it was saved");
        serde_json::from_str(&text).expect("JSON")
    }
}

const STD: &str = "spec = 1\nsuite = \"exploration\"\nextends = \"whole.toml\"\n[sweep]\nseeds = 2\n\
                   [sweep.std]\npath = \"action.std\"\nvalues = [\"10 %\", \"5 %\"]\n";

/// Id and stages of every run, by name.
fn runs(plan: &Value) -> BTreeMap<String, (String, BTreeMap<String, String>)> {
    let run = |arm: &Value| {
        let stages = arm["stages"].as_object().expect("stages");
        let stages = stages.iter().map(|(name, key)| (name.clone(), key.as_str().expect("a key").to_owned()));
        let id = arm["run"]["id"].as_str().expect("an id").to_owned();
        (arm["name"].as_str().expect("a name").to_owned(), (id, stages.collect()))
    };
    plan["arms"].as_array().expect("arms").iter().map(run).collect()
}

#[test]
fn a_point_and_a_seed_more_leave_ids_and_fingerprints_alone() {
    let folder = Folder::new(STD);
    let before = runs(&folder.plan());
    assert_eq!(before.len(), 4);
    folder.write(&STD.replace("\"5 %\"]", "\"2 %\", \"5 %\"]").replace("seeds = 2", "seeds = [3, 2, 1]"));
    let after = runs(&folder.plan());
    assert_eq!(after.len(), 9);
    for (name, run) in &before {
        assert_eq!(after.get(name), Some(run), "{name}");
    }
}

#[test]
fn an_arm_may_have_fewer_seeds_than_another() {
    let fewer = |seeds: &str| format!("{STD}[[sweep.exclude]]\nstd = \"5 %\"\nseeds = {seeds}\n");
    let folder = Folder::new(STD);
    let all = runs(&folder.plan());
    folder.write(&fewer("[2]"));
    let some = runs(&folder.plan());
    assert_eq!(some.keys().collect::<Vec<_>>(), ["std=10 %,seed=1", "std=10 %,seed=2", "std=5 %,seed=1"]);
    assert!(some.iter().all(|(name, run)| all[name] == *run), "what is left is the same");
    let text = folder.text(&["plan", "suite.toml"]);
    assert!(text.starts_with("exploration: 2 arms x up to 2 seeds = 3 runs"), "{text}");
    // An arm without a seed is no arm.
    folder.write(&fewer("[1, 2]"));
    assert_eq!(runs(&folder.plan()).len(), 2);
    // A profile or an assignment may have none of the seeds that are left out.
    let text = folder.text(&["plan", "suite.toml", "--set", "sweep.seeds=[7]"]);
    assert!(text.starts_with("exploration: 2 arms x 1 seed = 2 runs"), "{text}");
}

#[test]
fn the_claims_of_arms_with_fewer_seeds_have_their_power() {
    let claims = "[[claim]]\nid = \"c\"\ntext = \"More\"\nmetric = \"evaluate.nominal.survival\"\n\
                  compare = { a = \"std=10 %\", b = \"std=5 %\" }\nexpect = \"a > b\"\n";
    let folder = Folder::new(&STD.replace("seeds = 2", "seeds = 4"));
    folder.write(&format!(
        "{}[[sweep.exclude]]\nstd = \"5 %\"\nseeds = [3, 4]\n{claims}",
        STD.replace("seeds = 2", "seeds = 4")
    ));
    let text = folder.text(&["plan", "suite.toml", "--power"]);
    assert!(text.contains("c      welch  2 seeds"), "{text}");
}

#[test]
fn another_axis_renames_a_run_and_changes_neither_its_id_nor_its_stages() {
    let folder = Folder::new(STD);
    let before = runs(&folder.plan());
    folder.write(&format!("{STD}[sweep.samples]\npath = \"learn.samples\"\nvalues = [\"1 M\", \"2 M\"]\n"));
    let after = runs(&folder.plan());
    assert_eq!(before["std=10 %,seed=1"], after["std=10 %,samples=1 M,seed=1"]);
    assert_ne!(before["std=10 %,seed=1"], after["std=10 %,samples=2 M,seed=1"]);
}

#[test]
fn a_run_has_an_id_of_its_own_values() {
    let runs = runs(&Folder::new(STD).plan());
    let ids: std::collections::BTreeSet<&String> = runs.values().map(|(id, _)| id).collect();
    assert_eq!(ids.len(), 4);
    assert!(ids.iter().all(|id| id.len() == 12));
}

#[test]
fn seeds_change_pretraining_and_learning_and_nothing_before_them() {
    let runs = runs(&Folder::new(STD).plan());
    let (_, first) = &runs["std=10 %,seed=1"];
    let (_, second) = &runs["std=10 %,seed=2"];
    let same: Vec<&str> =
        first.keys().filter(|stage| first[*stage] == second[*stage]).map(String::as_str).collect();
    assert_eq!(same, ["controller", "env", "motion", "robot"]);
}

#[test]
fn arms_and_seeds_are_evaluated_with_the_same_recipe_on_other_policies() {
    let plan = Folder::new(STD).plan();
    let stages = plan["stages"].as_array().expect("stages");
    let evaluations: Vec<&Value> = stages.iter().filter(|stage| stage["kind"] == "evaluate").collect();
    assert_eq!(evaluations.len(), 4, "each run has a policy of its own");
    for evaluation in &evaluations {
        // The streams of commands, pushes and starts are named by this seed alone (src/evaluate/protocol.rs).
        assert_eq!(evaluation["recipe"]["fields"], evaluations[0]["recipe"]["fields"]);
        assert_eq!(evaluation["fields"]["evaluate"]["table"]["seed"]["count"], 1000);
        assert!(
            evaluation["recipe"]["fields"].get("learn").is_none(),
            "no learning seed reaches an evaluation"
        );
    }
}

#[test]
fn a_run_is_what_its_spec_is_alone() {
    let folder = Folder::new(STD);
    let suite = runs(&folder.plan());
    let alone = folder.text(&[
        "plan",
        "whole.toml",
        "--set",
        "learn.seed=2",
        "--set",
        "action.std=5 %",
        "--format",
        "json",
    ]);
    let alone: Value = serde_json::from_str(&alone).expect("JSON");
    let (_, run) = &suite["std=5 %,seed=2"];
    for stage in alone["stages"].as_array().expect("stages").iter().filter(|stage| stage["kind"] != "report")
    {
        let name = stage["name"].as_str().expect("a name");
        assert_eq!(stage["key"].as_str(), run.get(name).map(String::as_str), "{name}");
    }
}

#[test]
fn the_plan_of_a_suite_is_a_screen_and_lists_everything_when_asked() {
    let folder = Folder::new(STD);
    let short = folder.text(&["plan", "suite.toml"]);
    assert!(short.contains("exploration: 2 arms x 2 seeds = 4 runs"), "{short}");
    assert!(short.contains("learner"), "{short}");
    assert!(short.lines().count() < 30, "{short}");
    let all = folder.text(&["plan", "suite.toml", "--all"]);
    assert!(all.contains("\nstd=5 %,seed=2\n"), "{all}");
    assert!(folder.text(&["plan", "suite.toml", "--format", "mermaid"]).contains("4 x learner"));
    assert!(folder.text(&["plan", "suite.toml", "--format", "dot"]).contains("4 x learner"));
}

#[test]
fn every_stage_of_a_suite_has_a_name_of_its_own() {
    // Its evaluations `home` and `flat` of a policy are one stage, so a run uses that stage twice.
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(["plan", "specs/studies/contact_force.toml", "--format", "json", "--store", "none"]);
    let plan: Value = serde_json::from_slice(&command.output().expect("it runs").stdout).expect("JSON");
    let mut names = BTreeMap::new();
    for stage in plan["stages"].as_array().expect("stages") {
        *names.entry(stage["name"].as_str().expect("a name")).or_insert(0) += 1;
    }
    let several: Vec<_> = names.iter().filter(|(_, count)| **count > 1).collect();
    assert!(names.len() > 100 && several.is_empty(), "{several:?}");
    assert!(names.contains_key("control=torque/env"), "a stage of all seeds has none: {:?}", names.keys());
}

#[test]
fn origins_name_the_point_and_the_seeds() {
    let plan = Folder::new(STD).plan();
    let origins = &plan["arms"][2]["origins"];
    assert_eq!(origins["action.std"], "point std=5 %, suite.toml:8");
    assert_eq!(origins["learn.seed"], "sweep.seeds, suite.toml:5");
    assert_eq!(origins["action.rate"], "whole.toml:29");
}

#[test]
fn a_profile_of_a_suite_chooses_the_seeds_and_that_of_the_arms_applies_too() {
    let folder = Folder::new(&format!("{STD}[profile.quick]\nsweep.seeds = [7]\nclaims = \"count\"\n"));
    folder.text(&["plan", "suite.toml", "--profile", "quick", "--save", "plan.json"]);
    let text = fs::read_to_string(folder.0.path().join("plan.json")).expect("saved");
    let plan: Value = serde_json::from_str(&text).expect("JSON");
    let names: Vec<&str> =
        plan["arms"].as_array().expect("arms").iter().filter_map(|arm| arm["name"].as_str()).collect();
    assert_eq!(names, ["std=10 %,seed=7", "std=5 %,seed=7"]);
    assert_eq!(plan["arms"][0]["fields"]["learn"]["table"]["samples"]["count"], 200_000);
}

#[test]
fn each_file_is_read_once_however_many_arms_extend_it() {
    let folder = Folder::new(STD);
    let checked = check::suite(&folder.path(), &LoadOptions::default());
    assert!(!checked.sink.has_errors());
    assert_eq!(checked.arms.len(), 2);
    let texts = (0..).map_while(|id| checked.arms.first().map(|_| id)).take(4);
    let names: Vec<String> = texts
        .map(|id| checked.sources.get(specforge::diag::SourceId(id)).name.display().to_string())
        .collect();
    let last = |name: &String| name.rsplit('/').next().unwrap_or_default().to_owned();
    assert_eq!(
        names.iter().map(last).collect::<Vec<_>>(),
        ["suite.toml", "whole.toml", "tocabi.toml", "walk.toml"]
    );
}
