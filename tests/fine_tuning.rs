//! Fine-tuning: which stages it is made of and what they share with a spec that has none; and, with the
//! engines, that it goes on from the first policy, resumes to the same bytes, and is measured as the policy
//! that it is.

mod arms;

use arms::{arm, key, plan, set, table, word};
use specforge::plan::expected::Expected;
use specforge::plan::{Arm, Plan, StageKind, State, Status, TUNED_ENV, render};
use specforge::spec::Value;

fn rough() -> Value {
    table([("kind", word("height_field")), ("amplitude", arms::quantity(0.03, "3 cm"))])
}

/// An arm with a fine-tuning on rough ground.
fn tuned(more: &[(&str, Value)]) -> Arm {
    let mut tuned = arm("torque", "torque");
    let tuning = [("kind", word("ppo")), ("samples", Value::Count(1_000_000)), ("terrain", rough())];
    set(&mut tuned, "fine_tune", table(tuning), "specs/a.toml:5");
    more.iter().for_each(|(path, value)| set(&mut tuned, path, value.clone(), "--set"));
    tuned
}

/// What flows into a stage: `role=stage`.
fn inputs(plan: &Plan, stage: &str) -> Vec<String> {
    let inputs = plan.inputs(plan.find(stage)[0]).into_iter();
    inputs.map(|(from, edge)| format!("{}={}", edge.role, from.name())).collect()
}

#[test]
fn a_fine_tuning_leaves_the_first_training_and_what_is_measured_of_it_as_they_were() {
    let without = plan(&[arm("torque", "torque")]);
    let with = plan(&[tuned(&[("evaluate.nominal.policy", word("learner"))])]);
    for stage in ["env", "controller", "pretrain", "learner", "evaluate.nominal"] {
        assert_eq!(key(&with, "torque", stage), key(&without, "torque", stage), "{stage}");
    }
    for stage in ["deploy.policy", "deploy.mujoco"] {
        assert_ne!(key(&with, "torque", stage), key(&without, "torque", stage), "{stage}");
    }
}

#[test]
fn the_last_policy_is_meant_in_its_own_world_unless_the_first_is_named() {
    let last = plan(&[tuned(&[])]);
    assert_eq!(inputs(&last, "fine_tune"), ["controller=controller", "env=fine_tune.env", "learner=learner"]);
    let of_the_last = ["controller=controller", "env=fine_tune.env", "learner=fine_tune"];
    assert_eq!(inputs(&last, "evaluate.nominal"), of_the_last);
    assert_eq!(inputs(&last, "deploy.policy"), of_the_last);
    assert_eq!(inputs(&last, "deploy.mujoco"), ["env=fine_tune.env", "policy=deploy.policy"]);
    let first = plan(&[tuned(&[("evaluate.nominal.policy", word("learner"))])]);
    assert_eq!(inputs(&first, "evaluate.nominal"), ["controller=controller", "env=env", "learner=learner"]);
}

#[test]
fn the_text_of_a_plan_says_which_policy_a_stage_takes() {
    let plan = plan(&[tuned(&[(
        "evaluate.first",
        table([("kind", word("episodes")), ("policy", word("learner"))]),
    )])]);
    let missing = || Status { state: State::Missing, changes: Vec::new(), note: None };
    let statuses = plan.stages().map(|stage| (stage.fingerprint.clone(), missing())).collect();
    let text = render::text(&plan, &statuses, &Expected::default());
    let line = |stage: &str| {
        text.lines().find(|line| line.trim_start().starts_with(stage)).unwrap_or_default().to_owned()
    };
    assert!(line("evaluate.nominal").ends_with("<- controller, fine_tune.env, fine_tune"), "{text}");
    assert!(line("evaluate.first").ends_with("<- controller, env, learner"), "{text}");
}

#[test]
fn each_policy_is_exported_and_transferred_by_itself() {
    let export = table([("kind", word("export")), ("policy", word("learner"))]);
    let transfer =
        table([("kind", word("transfer")), ("engine", word("mujoco")), ("policy", word("learner"))]);
    let both = plan(&[tuned(&[("deploy.a_first", export), ("deploy.first_in_mujoco", transfer)])]);
    assert_eq!(inputs(&both, "deploy.first_in_mujoco"), ["env=env", "policy=deploy.a_first"]);
    assert_eq!(inputs(&both, "deploy.mujoco"), ["env=fine_tune.env", "policy=deploy.policy"]);
}

#[test]
fn the_world_of_a_fine_tuning_is_that_of_a_spec_on_its_ground() {
    let mut there = arm("there", "torque");
    set(&mut there, "terrain", rough(), "");
    set(&mut there, "action.std", arms::quantity(0.05, "5 %"), "");
    set(&mut there, "physics.engine", Value::Text("mujoco".into()), "");
    set(&mut there, "reward.contact_force.weight", arms::quantity(0.6, "0.6"), "");
    let engine = ("fine_tune.engine", Value::Text("mujoco".into()));
    let weight = ("fine_tune.weights", table([("contact_force", arms::quantity(0.6, "0.6"))]));
    let mut here = tuned(&[("fine_tune.std", arms::quantity(0.05, "5 %")), engine, weight]);
    here.origins.insert("fine_tune.weights.contact_force".into(), "specs/a.toml:9".into());
    here.origins.insert("fine_tune.terrain.amplitude".into(), "specs/a.toml:8".into());
    here.origins.insert("terrain.kind".into(), "specs/base/biped.toml:15".into());
    let both = plan(&[here, there]);
    assert_eq!(key(&both, "torque", TUNED_ENV), key(&both, "there", "env"));
    let stage = both.find(TUNED_ENV)[0];
    assert_eq!((stage.kind, stage.origins["terrain.amplitude"].as_str()), (StageKind::Env, "specs/a.toml:8"));
    assert_eq!((stage.origins["action.std"].as_str(), stage.origins.get("terrain.kind")), ("--set", None));
    assert_eq!(stage.origins["reward.contact_force.weight"], "specs/a.toml:9");
    assert_eq!(both.spec_path(stage, "terrain.amplitude"), "fine_tune.terrain.amplitude");
    assert_eq!(both.spec_path(stage, "physics.engine"), "fine_tune.engine");
}

#[test]
fn what_the_fine_tuning_says_of_learning_changes_nothing_before_it() {
    let (before, after) = (plan(&[tuned(&[])]), plan(&[tuned(&[("fine_tune.warm_up", Value::Count(3))])]));
    for stage in ["learner", TUNED_ENV] {
        assert_eq!(key(&before, "torque", stage), key(&after, "torque", stage), "{stage}");
    }
    for stage in ["fine_tune", "evaluate.nominal", "deploy.mujoco"] {
        assert_ne!(key(&before, "torque", stage), key(&after, "torque", stage), "{stage}");
    }
}

#[cfg(all(feature = "rapier", feature = "mujoco"))]
mod trained {
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    use rustix::process::{Pid, Signal, kill_process};

    /// Where the parent of the spec is.
    const SPECS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/specs");

    /// Four updates of 256 samples, then as many on rough ground, a checkpoint after each.
    const SPEC: &str = r#"
spec    = 1
name    = "adaptive"
extends = "ROOT/specs/tocabi_walk_torque.toml"

[profile.quick.pretrain]
samples = 2000
epochs  = 1

[profile.quick.learn]
samples          = 1024
rollout          = 256
environments     = 4
minibatch        = 64
warm_up          = 1
checkpoint_every = 1

[fine_tune]
kind    = "ppo"
samples = 1536
warm_up = WARM_UP
terrain = { kind = "height_field", friction = 1.0, amplitude = "2 cm", start = "0.1 m" }

[evaluate.nominal]
enabled = false
[evaluate.before]
kind       = "episodes"
episodes   = 2
time_limit = "1 s"
policy     = "learner"
terrain    = { kind = "height_field", friction = 1.0, amplitude = "2 cm", start = "0.1 m" }
[evaluate.after]
kind       = "episodes"
episodes   = 2
time_limit = "1 s"

[deploy.mujoco]
enabled = false
[report]
compare = []
"#;

    /// A folder with the spec, and in it a store.
    fn workplace(warm_up: u32) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let spec = SPEC.replace("ROOT", env!("CARGO_MANIFEST_DIR")).replace("WARM_UP", &warm_up.to_string());
        fs::write(folder.path().join("adaptive.toml"), spec).unwrap();
        folder
    }

    fn run(folder: &Path, until: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(folder).args(["--store", "store", "run", "adaptive.toml", "--profile", "quick"]);
        command.args(["--jobs", "1", "--until", until, "--reports", "reports", "--allow-outside", SPECS]);
        command.env("OMP_NUM_THREADS", "1").stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    fn finish(folder: &Path, until: &str) {
        let output = run(folder, until).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// The files of the one entry of a kind of stage.
    fn file(folder: &Path, kind: &str, name: &str) -> Vec<u8> {
        let entries: Vec<PathBuf> = fs::read_dir(folder.join("store").join(kind))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        assert_eq!(entries.len(), 1, "{entries:?}");
        fs::read(entries[0].join(name)).unwrap()
    }

    /// Kills a training once it has written a checkpoint.
    fn kill_after_a_checkpoint(folder: &Path, child: &mut Child) {
        let written = || {
            let folders = fs::read_dir(folder.join("store/scratch")).into_iter().flatten().flatten();
            let mut files =
                folders.flat_map(|folder| fs::read_dir(folder.path()).into_iter().flatten().flatten());
            files.any(|file| file.file_name().to_string_lossy().starts_with("checkpoint"))
        };
        let start = Instant::now();
        while !written() {
            assert!(child.try_wait().unwrap().is_none(), "the fine-tuning ended before it was stopped");
            assert!(start.elapsed() < Duration::from_secs(300), "no checkpoint was written");
            std::thread::sleep(Duration::from_millis(5));
        }
        kill_process(Pid::from_child(child), Signal::KILL).unwrap();
        child.wait().unwrap();
    }

    #[test]
    fn a_fine_tuning_that_was_killed_goes_on_to_the_same_bytes() {
        let (whole, broken) = (workplace(1), workplace(1));
        finish(whole.path(), "fine_tune");
        finish(broken.path(), "learner");
        let mut child = run(broken.path(), "fine_tune").stderr(Stdio::null()).spawn().unwrap();
        kill_after_a_checkpoint(broken.path(), &mut child);
        assert!(!broken.path().join("store/fine_tune").exists(), "it was over before it was killed");
        finish(broken.path(), "fine_tune");
        for name in ["actor.safetensors", "critic.safetensors"] {
            let [expected, found] =
                [whole.path(), broken.path()].map(|folder| file(folder, "fine_tune", name));
            assert!(expected == found, "{name} differs");
            assert!(expected != file(whole.path(), "learner", name), "nothing was learned in {name}");
        }
    }

    /// The episodes of an evaluation.
    fn episodes(folder: &Path, stage: &str) -> serde_json::Value {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(folder).args(["--store", "store", "plan", "adaptive.toml", "--profile", "quick"]);
        let output = command.args(["--format", "json", "--allow-outside", SPECS]).output().unwrap();
        let plan: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let stages = plan["stages"].as_array().unwrap();
        let stage = stages
            .iter()
            .find(|entry| entry["name"] == stage)
            .unwrap_or_else(|| panic!("no {stage}: {plan}"));
        let key = stage["key"].as_str().unwrap();
        let path = folder.join("store/evaluate").join(key).join("evaluation.json");
        let evaluation: serde_json::Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
        evaluation["episodes"].clone()
    }

    #[test]
    fn a_fine_tuning_begins_with_the_actions_of_the_first_policy() {
        // Six updates in which the critic alone learns: the actor is what it was at the start.
        let still = workplace(6);
        finish(still.path(), "adaptive/evaluate.after");
        finish(still.path(), "adaptive/evaluate.before");
        let actors = ["learner", "fine_tune"].map(|kind| file(still.path(), kind, "actor.safetensors"));
        assert!(actors[0] == actors[1], "the actor has changed");
        let critics = ["learner", "fine_tune"].map(|kind| file(still.path(), kind, "critic.safetensors"));
        assert!(critics[0] != critics[1], "the critic has learned nothing");
        // The first policy on the ground of the fine-tuning, and the fine-tuned one in its own world: the
        // same episodes.
        assert_eq!(episodes(still.path(), "evaluate.before"), episodes(still.path(), "evaluate.after"));
    }
}
