//! What is said twice is held against its source, and missing evidence is never a pass.

mod arms;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, SystemTime};

use arms::{Fake, arm, execute, plan, quantity, set};
use serde_json::{Value, json};
use specforge::exec::lock::Wait;
use specforge::exec::manifest::{Depth, Manifest};
use specforge::exec::{Event, Store, StoreError, gc};
use specforge::plan::{Cached, Plan, StageKind};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// The program with a store of its own.
fn specforge(store: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1").arg("--store").arg(store);
    command.args(arguments).output().expect("the program can be started")
}

/// The exit code and everything that was said.
fn told(output: &Output) -> (i32, String) {
    let text =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat();
    (output.status.code().expect("it ends by itself"), text)
}

// Saved plans.

/// The pointers of all leaves of a value.
fn leaves(value: &Value, at: &str, found: &mut Vec<String>) {
    let below = |step: &str| format!("{at}/{}", step.replace('~', "~0").replace('/', "~1"));
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| leaves(value, &below(key), found)),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| leaves(item, &below(&i.to_string()), found))
        }
        _ => found.push(at.to_owned()),
    }
}

/// Another value of the same type.
fn changed(value: &Value) -> Value {
    match value {
        Value::Bool(flag) => json!(!flag),
        Value::Number(number) if number.is_u64() => json!(number.as_u64().unwrap_or_default() + 1),
        Value::Number(number) => json!(number.as_f64().unwrap_or_default() + 0.5),
        Value::String(text) if text.len() == 64 => json!("0".repeat(64)),
        Value::String(text) => json!(format!("{text}x")),
        _ => json!(1),
    }
}

#[test]
fn whatever_is_edited_in_one_place_of_a_saved_plan_is_refused() {
    let mut position = arm("position", "position");
    position.allow.insert("W0501".into(), "it is meant".into());
    let plan = plan(&[arm("torque", "torque"), position]);
    let whole = serde_json::to_value(&plan).expect("plain data");
    let mut places = Vec::new();
    leaves(&whole, "", &mut places);
    assert!(places.len() > 400, "{}", places.len());
    for place in places {
        let mut edited = whole.clone();
        let leaf = edited.pointer_mut(&place).expect("it is there");
        *leaf = changed(leaf);
        let error = Plan::from_json(&edited.to_string()).map(drop).expect_err(&place).to_string();
        assert!(!error.is_empty() && !error.contains("another version"), "{place}: {error}");
    }
    // What only one place says: how the user asked, and what no stage reads.
    for (place, named) in [
        ("/arms/0/request/spec", "arms[].request.spec"),
        ("/arms/1/request/spec", "arms[].request.spec"),
        ("/arms/1/allow/W0501", "arms[].allow"),
        ("/arms/1/fields/report/table/template/text", "arms[].fields"),
    ] {
        let mut edited = whole.clone();
        *edited.pointer_mut(place).expect("it is there") = json!("another");
        let error = Plan::from_json(&edited.to_string()).expect_err(place).to_string();
        let expected = format!("the plan was edited after it was saved: `{named}` is not what was saved");
        assert_eq!(error, expected, "{place}");
    }
    let mut placed = whole.clone();
    placed["arms"][0]["request"]["place"] = json!("specs/other.toml");
    let error = Plan::from_json(&placed.to_string()).expect_err("another spec").to_string();
    assert!(error.contains("`arms[].request.place` is not what was saved"), "{error}");
    let mut stripped = whole.clone();
    stripped.as_object_mut().expect("an object").shift_remove("digests");
    let error = Plan::from_json(&stripped.to_string()).expect_err("no digests").to_string();
    assert!(error.contains("the plan has no digests of its parts: they were removed"), "{error}");
    // Entries that are removed.
    for place in
        ["/arms/1", "/stages/0", "/stages/5", "/arms/0/stages/learner", "/stages/4/recipe/inputs/env"]
    {
        let mut edited = whole.clone();
        let (above, key) = place.rsplit_once('/').expect("a pointer");
        match edited.pointer_mut(above).expect("it is there") {
            Value::Array(items) => drop(items.remove(key.parse().expect("an index"))),
            Value::Object(map) => drop(map.shift_remove(key)),
            _ => unreachable!("it has entries"),
        }
        if edited != whole {
            assert!(Plan::from_json(&edited.to_string()).is_err(), "{place}");
        }
    }
}

/// A saved plan of a spec or suite.
fn saved(store: &Path, spec: &str, more: &[&str]) -> PathBuf {
    let path = store.with_file_name("plan.json");
    let name = path.to_string_lossy().into_owned();
    let (code, text) = told(&specforge(store, &[&["plan", spec, "--save", &name], more].concat()));
    assert_eq!(code, 0, "{text}");
    path
}

#[test]
fn saved_plans_of_specs_and_suites_are_read_again() {
    for (spec, more) in [
        ("specs/atlas_run_torque.toml", &["--profile", "quick"][..]),
        ("specs/tocabi_squat_torque.toml", &["--set", "learn.samples=40k"]),
        ("specs/paper/paper_exp1.toml", &[]),
        ("specs/studies/payload.toml", &["--profile", "desk"]),
    ] {
        let folder = folder();
        let store = folder.path().join("store");
        let path = saved(&store, spec, more);
        let (code, text) = told(&specforge(&store, &["plan", &path.to_string_lossy()]));
        assert_eq!(code, 0, "{spec}: {text}");
    }
}

#[test]
fn a_plan_whose_seed_was_edited_in_the_fields_never_runs() {
    let folder = folder();
    let store = folder.path().join("store");
    let path = saved(&store, "specs/tocabi_squat_torque.toml", &["--profile", "quick"]);
    let mut plan: Value = serde_json::from_str(&fs::read_to_string(&path).expect("saved")).expect("JSON");
    let stages = plan["stages"].as_array_mut().expect("a list");
    let learner = stages.iter_mut().find(|stage| stage["kind"] == "learner").expect("it learns");
    learner["fields"]["learn"]["table"]["seed"]["count"] = json!(99);
    fs::write(&path, plan.to_string()).expect("it can be written");
    let name = path.to_string_lossy().into_owned();
    for words in [
        &["run", &name][..],
        &["plan", &name],
        &["why", &name, "learner"],
        &["stage", "robot", "--plan", &name],
    ] {
        let (code, text) = told(&specforge(&store, words));
        assert!(
            code == 3 && text.contains("error[E0811]") && text.contains("learn.seed"),
            "{words:?}: {text}"
        );
    }
    assert!(!store.join("robot").exists());
}

#[test]
fn a_plan_of_another_version_is_refused() {
    let plan = plan(&[arm("torque", "torque")]);
    let mut old = serde_json::to_value(&plan).expect("plain data");
    let learner = plan.stages().position(|stage| stage.kind == StageKind::Learner).expect("it learns");
    let mut stage = plan.stages().nth(learner).expect("it is there").clone();
    stage.recipe.epoch -= 1;
    stage.fingerprint = stage.recipe.fingerprint();
    old["stages"][learner] = serde_json::to_value(&stage).expect("plain data");
    // The same edit without new digests is an edit.
    let edited = Plan::from_json(&old.to_string()).expect_err("edited").to_string();
    assert!(
        edited.starts_with("the plan was edited after it was saved: `stages` is not what was saved ("),
        "{edited}"
    );
    assert!(edited.contains("the stage `learner` has epoch"), "{edited}");
    let mut stages: Vec<_> = plan.stages().cloned().collect();
    stages[learner] = stage;
    let digests = specforge::plan::digests::of(&plan.arms, plan.suite.as_ref(), &stages);
    old["digests"] = serde_json::to_value(digests).expect("plain data");
    let error = Plan::from_json(&old.to_string()).expect_err("another epoch");
    assert!(error.to_string().contains("saved by another version of specforge"), "{error}");
    let specforge::plan::SavedError::Plan(error) = error else { panic!("{error}") };
    assert_eq!(error.code(), "E0812");
}

#[test]
fn a_text_that_says_another_number_than_its_value_is_refused() {
    let mut wrong = arm("torque", "torque");
    set(&mut wrong, "action.delay", quantity(0.008, "4 ms"), "--set");
    let text = serde_json::to_string(&plan(&[wrong])).expect("plain data");
    let error = Plan::from_json(&text).expect_err("0.008 s is not 4 ms").to_string();
    assert!(error.contains("`action.delay` reads \"4 ms\" and has the value 0.008"), "{error}");
}

#[test]
fn a_report_that_would_leave_its_folder_is_refused() {
    for name in ["../../page", "a/b", "..", "", "a\u{1b}[2J"] {
        let (suite, baselines) = (None, Vec::new());
        let source =
            specforge::plan::ReportSource { name: name.into(), templates: "t".into(), suite, baselines };
        let plan = specforge::plan::lower(&[arm("torque", "torque")], Some(&source)).expect("whole");
        let text = serde_json::to_string(&plan).expect("plain data");
        assert!(Plan::from_json(&text).is_err(), "{name:?}");
    }
}

// Artefacts.

/// Changes a stored artefact's manifest and seals it again.
fn reseal(folder: &Path, change: impl FnOnce(&mut Manifest)) {
    let path = folder.join("manifest.json");
    let text = fs::read_to_string(&path).expect("a manifest");
    let mut manifest = Manifest::from_text(&text).expect("it is whole");
    change(&mut manifest);
    fs::write(&path, manifest.to_text()).expect("it can be written");
}

/// Changes a file of a stored artefact, with its digest in a manifest that is sealed again.
fn rewrite(folder: &Path, name: &str, content: &[u8]) {
    fs::write(folder.join(name), content).expect("it can be written");
    reseal(folder, |manifest| {
        manifest.files.retain(|file| file.path != name);
        let (path, size) = (name.to_owned(), content.len() as u64);
        let blake3 = blake3::hash(content).to_hex().to_string();
        manifest.files.push(specforge::exec::manifest::FileRecord { path, size, blake3 });
    });
}

/// A store in which everything of an arm was made.
fn made() -> (tempfile::TempDir, Plan) {
    let (store, plan) = (folder(), plan(&[arm("torque", "torque")]));
    execute(&plan, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    (store, plan)
}

/// The folder of an artefact.
fn artefact(store: &Path, plan: &Plan, name: &str) -> PathBuf {
    let stage = plan.find(name)[0];
    Store::at(store).folder(stage.kind, &stage.fingerprint)
}

/// Looks at an artefact as a rerun does, as `verify` does, and lets a rerun make it again.
#[track_caller]
fn is_found(store: &Path, plan: &Plan, name: &str, why: &str) {
    let stage = plan.find(name)[0];
    let Cached::Damaged(reason) = Store::at(store).inspect(stage.kind, &stage.fingerprint, Depth::Quick)
    else {
        panic!("{name} passes: {why}");
    };
    assert!(reason.contains(why), "{reason}");
    let (code, text) = told(&specforge(store, &["cache", "verify"]));
    assert!(code == 4 && text.contains(why) && text.contains("R0003"), "{text}");
    let ran = execute(plan, store, &Fake::default(), 2);
    let warned = ran
        .record
        .events()
        .into_iter()
        .any(|event| matches!(event, Event::Warning { code: Some(code), .. } if code == "R0003"));
    assert!(warned && ran.outcome.expect("the store works").worked.len() == 1);
    assert_eq!(told(&specforge(store, &["cache", "verify"])).0, 0);
}

#[test]
fn a_manifest_whose_fields_are_not_those_of_its_recipe_is_found() {
    let (store, plan) = made();
    let learner = artefact(store.path(), &plan, "learner");
    reseal(&learner, |manifest| {
        let Some(specforge::spec::Value::Table(learn)) = manifest.stage.fields.get_mut("learn") else {
            panic!("a table")
        };
        learn.insert("seed".into(), specforge::spec::Value::Count(99));
    });
    is_found(store.path(), &plan, "learner", "`learn.seed` has another value");
    let env = artefact(store.path(), &plan, "env");
    reseal(&env, |manifest| {
        let Some(specforge::spec::Value::Table(action)) = manifest.stage.fields.get_mut("action") else {
            panic!("a table")
        };
        action.insert("delay".into(), quantity(0.004, "8 ms"));
    });
    is_found(store.path(), &plan, "env", "the text of `action.delay` says another number");
}

#[test]
fn an_artefact_under_another_kind_and_a_file_that_no_manifest_lists_are_found() {
    let (store, plan) = made();
    let stage = plan.find("learner")[0];
    let learner = artefact(store.path(), &plan, "learner");
    let pretend = Store::at(store.path()).folder(StageKind::FineTune, &stage.fingerprint);
    fs::create_dir_all(&pretend).expect("a folder");
    for name in ["manifest.json", "made.json"] {
        fs::copy(learner.join(name), pretend.join(name)).expect("copied");
    }
    let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
    assert!(code == 4 && text.contains("of a stage of another kind"), "{text}");
    fs::remove_dir_all(store.path().join("fine_tune")).expect("it is there");
    fs::write(learner.join("metrics.jsonl"), "{}").expect("it can be written");
    is_found(store.path(), &plan, "learner", "metrics.jsonl is not in manifest.json");
}

#[test]
fn notes_and_droppings_beside_an_artefact_are_told_and_nothing_is_made_again() {
    let (store, plan) = made();
    let learner = artefact(store.path(), &plan, "learner");
    fs::create_dir(learner.join("old")).expect("a folder");
    for name in ["notes.txt", ".DS_Store", "made.json~", ".made.json.swp", "#made.json#", "old/made.json"] {
        fs::write(learner.join(name), "not a result").expect("it can be written");
    }
    std::os::unix::fs::symlink("nowhere", learner.join("link")).expect("a link");
    let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
    assert!(code == 0 && text.contains("not part of the artefact, and ignored: "), "{text}");
    for name in ["notes.txt", ".DS_Store", "made.json~", "old/made.json", "link"] {
        assert!(text.contains(name), "{name}: {text}");
    }
    let output = specforge(store.path(), &["--format", "json", "cache", "verify"]);
    let found: Value = serde_json::from_slice(&output.stdout).expect("a document");
    assert_eq!(found["damaged"], json!([]), "{found}");
    assert_eq!(found["strays"][0]["files"].as_array().map(Vec::len), Some(7), "{found}");
    let outcome = execute(&plan, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    assert!(outcome.worked.is_empty(), "nothing is made again");
    assert!(learner.join("notes.txt").is_file());
}

#[test]
fn results_with_numbers_that_are_not_finite_are_found_and_made_again() {
    let (store, plan) = made();
    let metrics = br#"{"update":0,"samples":9,"episodes":2,"return_mean":null,"length_mean_s":1.0}"#;
    for (stage, name, content, why) in [
        ("pretrain", "pretrain.json", &br#"{"rmse_nm":null}"#[..], "`rmse_nm` is not a finite number"),
        ("learner", "metrics.jsonl", &metrics[..], "`return_mean` in line 1 is not a finite number"),
        (
            "learner",
            "summary.json",
            br#"{"cpu_us_per_sample":null}"#,
            "`cpu_us_per_sample` is not a finite number",
        ),
        (
            "evaluate.nominal",
            "evaluation.json",
            br#"{"command":null,"episodes":[{"speed":null}]}"#,
            "`episodes.0.speed`",
        ),
        ("robot", "robot.json", br#"{"mass":null}"#, "robot.json"),
    ] {
        rewrite(&artefact(store.path(), &plan, stage), name, content);
        is_found(store.path(), &plan, stage, why);
    }
}

#[test]
fn copies_in_an_artefact_that_contradict_their_source_are_found() {
    let (store, plan) = made();
    let learner = artefact(store.path(), &plan, "learner");
    let summary = |updates: u64, mean: f64| {
        json!({"updates": updates, "samples": 9, "return_mean": mean, "length_mean_s": 1.0}).to_string()
    };
    rewrite(
        &learner,
        "metrics.jsonl",
        br#"{"samples":9,"episodes":2,"return_mean":3.0,"length_mean_s":1.0}"#,
    );
    rewrite(&learner, "summary.json", summary(1, 3.0).as_bytes());
    assert_eq!(told(&specforge(store.path(), &["cache", "verify"])).0, 0);
    rewrite(&learner, "summary.json", summary(1, 4.0).as_bytes());
    is_found(store.path(), &plan, "learner", "summary.json says other `return_mean`");
    rewrite(
        &learner,
        "metrics.jsonl",
        br#"{"samples":9,"episodes":2,"return_mean":3.0,"length_mean_s":1.0}"#,
    );
    rewrite(&learner, "summary.json", summary(2, 3.0).as_bytes());
    is_found(store.path(), &plan, "learner", "summary.json says other updates");
    let policy = fs::read("reports/policies/tocabi_walk_torque.safetensors").expect("it is committed");
    let export = artefact(store.path(), &plan, "deploy.policy");
    rewrite(&export, "policy.safetensors", &policy);
    rewrite(&export, "contract.json", br#"{"version":1}"#);
    is_found(store.path(), &plan, "deploy.policy", "contract.json is not the contract of policy.safetensors");
}

#[test]
fn a_robot_and_a_blueprint_are_those_of_their_stages() {
    let store = folder();
    let words = ["run", "specs/tocabi_squat_torque.toml", "--profile", "quick", "--until", "env"];
    assert_eq!(told(&specforge(store.path(), &words)).0, 0);
    let only = |kind: &str| {
        let mut entries = fs::read_dir(store.path().join(kind))
            .expect("it ran")
            .map(|entry| entry.expect("an entry").path());
        entries.next().expect("an artefact")
    };
    let edited = |kind: &str, name: &str, from: &str, to: &str| {
        let text = fs::read_to_string(only(kind).join(name)).expect("a file");
        assert!(text.contains(from), "{from}");
        rewrite(&only(kind), name, text.replacen(from, to, 1).as_bytes());
        let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
        assert_eq!(code, 4, "{text}");
        let ran =
            told(&specforge(store.path(), &[&words[..5], &["pretrain"][..0], &["controller"]].concat()));
        assert_eq!(ran.0, 0, "{}", ran.1);
        text
    };
    let env =
        edited("env", "env.json", "\"weight\":{\"quantity\":{\"si\":", "\"weight\":{\"quantity\":{\"si\":1");
    assert!(env.contains("env.json: `reward."), "{env}");
    fs::remove_dir_all(store.path().join("env")).expect("it is there");
    let robot = edited("robot", "robot.json", "\"effort_limit\":", "\"effort_limit\":1");
    assert!(robot.contains("robot.json is not the robot of its stage"), "{robot}");
}

// Numbers.

#[test]
fn a_result_with_a_number_that_is_not_finite_fails_its_stage_and_stores_nothing() {
    struct Overflow;
    impl specforge::exec::Work for Overflow {
        fn run(&self, job: &specforge::exec::Job) -> Result<(), specforge::exec::WorkError> {
            job.write("evaluation.json", &std::collections::BTreeMap::from([("speed", [1.0, f64::INFINITY])]))
        }
    }
    let (store, plan) = (folder(), plan(&[arm("torque", "torque")]));
    let mut works = arms::works(&Fake::default());
    works.insert(StageKind::Evaluate, Box::new(Overflow));
    let (at, record, interrupt) =
        (Store::at(store.path()), specforge::exec::events::Record::default(), Default::default());
    let workshop = specforge::exec::Workshop {
        plan: &plan,
        store: &at,
        works: &works,
        events: &record,
        interrupt: &interrupt,
    };
    let outcome = specforge::exec::run(&workshop, &arms::options(&plan, 2)).expect("the store works");
    let failure = &outcome.failures[0];
    assert_eq!(failure.code.as_deref(), Some("R0007"));
    assert!(failure.message.contains("evaluation.json: speed.1 is inf"), "{}", failure.message);
    assert!(at.keys(StageKind::Evaluate).is_empty());
}

// Cleaning.

/// Everything, whatever its age.
const ALL: gc::Rules = gc::Rules { age: Duration::ZERO, scratch: true, force: false };

fn refused(store: &Path, code: &str) -> StoreError {
    let error = gc::waste(&Store::at(store), &ALL, &Wait::default()).expect_err("nothing is proved");
    assert_eq!(error.code(), Some(code), "{error}");
    let (exit, text) = told(&specforge(store, &["cache", "gc", "--older-than", "0", "--scratch"]));
    assert!(exit == 4 && text.contains(&format!("[{code}]")), "{text}");
    error
}

/// All files below a folder.
fn files(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for path in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let inner = if path.is_dir() && !path.is_symlink() { files(&path) } else { BTreeSet::from([path]) };
        found.extend(inner);
    }
    found
}

/// Two runs of one name, so that the first has artefacts that the second no longer uses.
fn superseded() -> (tempfile::TempDir, Plan, Plan) {
    let (store, before) = made();
    let mut other = arm("torque", "torque");
    set(&mut other, "reward.contact_force.weight", quantity(0.2, "0.2"), "--set");
    let after = plan(&[other]);
    execute(&after, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    (store, before, after)
}

#[test]
fn a_journal_that_is_no_evidence_makes_cleaning_stop() {
    let (store, ..) = superseded();
    let journal = store.path().join("journal.jsonl");
    let text = fs::read_to_string(&journal).expect("a journal");
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let key = &text[text.find("\"fingerprint\":\"").expect("a key") + 15..][..64];
    let half = &text[..text.len() / 2];
    for changed in [
        String::new(),
        "\n".to_owned(),
        "garbage\n".to_owned(),
        half.to_owned(),
        lines[..lines.len() - 1].concat(),
        lines[1..].concat(),
        text.replacen(key, &"0".repeat(64), 1),
        text.replacen("torque", "torqve", 1),
        format!("{text}{}", lines[0]),
        format!("{text}{{\"run\":\"x\"}}\n"),
    ] {
        let before = files(store.path());
        fs::write(&journal, &changed).expect("it can be written");
        refused(store.path(), "E0814");
        let verified = told(&specforge(store.path(), &["cache", "verify"]));
        assert!(verified.0 == 4 && verified.1.contains("E0814"), "{}", verified.1);
        let after: BTreeSet<_> = files(store.path());
        assert!(before.is_subset(&after), "something was removed");
    }
    for name in ["journal.jsonl", "journal.seal"] {
        fs::remove_file(store.path().join(name)).expect("it is there");
        refused(store.path(), "E0814");
    }
}

#[test]
fn force_takes_the_journal_as_it_is_and_writes_a_whole_one() {
    let (store, _, after) = superseded();
    let journal = store.path().join("journal.jsonl");
    let text = fs::read_to_string(&journal).expect("a journal");
    fs::write(&journal, text.replacen("torque", "torqve", 1)).expect("it can be written");
    refused(store.path(), "E0814");
    let forced = ["cache", "gc", "--older-than", "0", "--force"];
    assert_eq!(told(&specforge(store.path(), &[&forced[..], &["--dry-run"]].concat())).0, 0);
    refused(store.path(), "E0814");
    assert_eq!(told(&specforge(store.path(), &forced)).0, 0);
    assert!(gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).is_ok());
    let outcome = execute(&after, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    assert!(outcome.worked.is_empty(), "what is used is there");
}

#[test]
fn what_no_line_names_is_kept_unless_it_is_forced() {
    let (store, plan) = made();
    // Another store's artefacts, copied by hand.
    let (other, ..) = superseded();
    let learners = other.path().join("learner");
    for entry in fs::read_dir(&learners).expect("it learned").map(|entry| entry.expect("an entry")) {
        let target = store.path().join("learner").join(entry.file_name());
        if !target.exists() {
            fs::create_dir(&target).expect("a folder");
            for file in files(&entry.path()) {
                fs::copy(&file, target.join(file.file_name().expect("a name"))).expect("copied");
            }
        }
    }
    let cleaning = gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).expect("the journal is whole");
    assert_eq!((cleaning.waste.len(), cleaning.unnamed), (0, 1));
    drop(cleaning);
    let forced = gc::waste(&Store::at(store.path()), &gc::Rules { force: true, ..ALL }, &Wait::default())
        .expect("the journal is whole");
    assert_eq!(forced.waste.len(), 1);
    drop(forced);
    assert!(artefact(store.path(), &plan, "learner").exists());
}

#[test]
fn a_time_in_the_future_or_none_is_not_old() {
    let (store, before, _) = superseded();
    let at = Store::at(store.path());
    let count = |age: Duration| {
        gc::waste(&at, &gc::Rules { age, ..ALL }, &Wait::default()).expect("the journal is whole").waste.len()
    };
    assert_eq!(count(Duration::ZERO), 6);
    let learner = artefact(store.path(), &before, "learner");
    let dated = |time: SystemTime| {
        let file = File::options().append(true).open(learner.join("manifest.json")).expect("a manifest");
        file.set_modified(time).expect("it can be dated");
    };
    dated(SystemTime::now() + Duration::from_secs(86_400));
    assert_eq!(count(Duration::ZERO), 5, "tomorrow");
    // The file's time says a year ago, the manifest itself says today.
    dated(SystemTime::now() - Duration::from_secs(365 * 86_400));
    assert_eq!(count(Duration::from_secs(3600)), 0, "today");
    assert_eq!(count(Duration::ZERO), 6);
    reseal(&learner, |manifest| manifest.provenance.finished = "2999-01-01T00:00:00Z".into());
    assert_eq!(count(Duration::ZERO), 5, "in a thousand years");
    reseal(&learner, |manifest| manifest.provenance.finished = "yesterday".into());
    assert_eq!(count(Duration::ZERO), 5, "no time");
}

#[test]
fn cleaning_beside_a_run_takes_nothing_that_it_uses() {
    let (store, before, after) = superseded();
    // A run of the first plan: all of it is there, and the journal has other artefacts under its names.
    let outcome = execute(&before, store.path(), &Fake::default(), 1).outcome.expect("the store works");
    execute(&after, store.path(), &Fake::default(), 1).outcome.expect("the store works");
    let scratch = store.path().join("scratch").join(before.find("learner")[0].fingerprint.as_str());
    fs::create_dir(&scratch).expect("a folder");
    let cleaning =
        || gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).expect("the journal is whole");
    let counts = |cleaning: gc::Cleaning| (cleaning.waste.len(), cleaning.leased);
    assert_eq!(counts(cleaning()), (0, 6), "its outcome is still in use");
    let (code, text) = told(&specforge(store.path(), &["cache", "gc", "--older-than", "0", "--scratch"]));
    assert!(code == 0 && text.contains("6 more are kept: a running process uses them"), "{text}");
    drop(outcome);
    assert_eq!(cleaning().waste.len(), 7, "with the checkpoint");
    assert!(fs::read_dir(store.path().join("leases")).expect("a folder").next().is_none(), "leases end");
}

#[test]
fn cleaning_removes_damaged_artefacts_of_any_age_and_none_that_a_run_uses() {
    let (store, plan) = made();
    let outcome = execute(&plan, store.path(), &Fake::default(), 1).outcome.expect("the store works");
    let folders = ["learner", "env", "robot"].map(|name| artefact(store.path(), &plan, name));
    fs::write(folders[0].join("made.json"), "{}").expect("it can be written");
    fs::remove_file(folders[1].join("manifest.json")).expect("a manifest");
    fs::write(folders[2].join("notes.txt"), "no damage").expect("it can be written");
    let clean = || told(&specforge(store.path(), &["cache", "gc"]));
    let (code, text) = clean();
    assert!(code == 0 && text.contains("2 more are kept: a running process uses them"), "{text}");
    drop(outcome);
    let (code, text) = told(&specforge(store.path(), &["cache", "gc", "--dry-run"]));
    assert!(code == 0 && text.contains("damaged learner") && folders[0].is_dir(), "{text}");
    let (code, text) = clean();
    assert!(code == 0 && text.contains("damaged learner") && text.contains("damaged env"), "{text}");
    assert_eq!(folders.each_ref().map(|folder| folder.exists()), [false, false, true], "{text}");
    let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
    assert!(code == 0 && text.contains(" 0 are damaged"), "{text}");
}

#[test]
fn cleaning_removes_links_in_place_of_artefacts_and_nothing_behind_them() {
    let (store, plan) = made();
    drop(execute(&plan, store.path(), &Fake::default(), 1));
    let outside = folder();
    let [learner, env, robot] = ["learner", "env", "robot"].map(|name| artefact(store.path(), &plan, name));
    fs::rename(&learner, outside.path().join("learner")).expect("it can be moved");
    std::os::unix::fs::symlink(outside.path().join("learner"), &learner).expect("a link");
    fs::remove_dir_all(&env).expect("it can be removed");
    std::os::unix::fs::symlink(outside.path().join("nothing"), &env).expect("a link");
    fs::remove_dir_all(&robot).expect("it can be removed");
    fs::write(&robot, "a file").expect("it can be written");
    let behind = files(outside.path());
    let moved = store.path().join("damaged/motion-0123456789ab-1");
    fs::create_dir_all(store.path().join("damaged")).expect("a folder");
    std::os::unix::fs::symlink(outside.path(), &moved).expect("a link");
    let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
    assert!(code == 4 && text.contains(" 3 are damaged"), "{text}");
    let (code, text) = told(&specforge(store.path(), &["cache", "gc", "--dry-run"]));
    assert!(code == 0 && learner.is_symlink() && text.contains("4 entries"), "{text}");
    let (code, text) = told(&specforge(store.path(), &["cache", "gc"]));
    assert_eq!(code, 0, "{text}");
    for path in [&learner, &env, &robot, &moved] {
        assert!(path.symlink_metadata().is_err(), "{}: {text}", path.display());
    }
    assert_eq!(files(outside.path()), behind);
    let (code, text) = told(&specforge(store.path(), &["cache", "verify"]));
    assert!(code == 0 && text.contains(" 0 are damaged"), "{text}");
}

#[test]
fn the_lease_of_a_process_that_was_killed_ends_with_it() {
    let (store, ..) = superseded();
    fs::write(store.path().join("leases/999999.0"), "0".repeat(64)).expect("it can be written");
    let cleaning = gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).expect("the journal is whole");
    assert_eq!((cleaning.waste.len(), cleaning.leased), (6, 0));
}

#[test]
fn only_a_store_is_cleaned() {
    let key = "0123456789abcdef".repeat(4);
    let photos = folder();
    let write = |path: &str| {
        let path = photos.path().join(path);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, "x").expect("it can be written");
    };
    for path in [
        "damaged/holiday.jpg",
        "scratch/notes.txt",
        "robot/arm.jpg",
        &format!("learner/{key}/a.jpg"),
        "b.jpg",
    ] {
        write(path);
    }
    let before = files(photos.path());
    refused(photos.path(), "E0813");
    let (code, text) =
        told(&specforge(photos.path(), &["cache", "gc", "--older-than", "0", "--scratch", "--force"]));
    assert!(code == 4 && text.contains("[E0813]"), "{text}");
    let verified = told(&specforge(photos.path(), &["cache", "verify"]));
    assert!(verified.0 == 4 && verified.1.contains("[E0813]"), "{}", verified.1);
    let words = ["run", "specs/tocabi_squat_torque.toml", "--profile", "quick", "--until", "robot"];
    let (code, text) = told(&specforge(photos.path(), &words));
    assert!(code == 4 && text.contains("[E0813]"), "{text}");
    assert_eq!(files(photos.path()), before);
    // An empty folder and none have no artefacts, which proves nothing about them.
    let nothing = folder();
    for place in [nothing.path().to_owned(), nothing.path().join("none")] {
        assert_eq!(told(&specforge(&place, &["cache", "verify"])).0, 4);
        let (code, text) = told(&specforge(&place, &["cache", "gc"]));
        assert!(code == 4 && text.contains("[E0813]"), "{text}");
        assert!(place == nothing.path() || !place.exists(), "cleaning makes no store");
    }
    // A store is not made among the files of a project, even if they are in nobody's way; nor is anything read there.
    let project = folder();
    fs::write(project.path().join("walk.toml"), "x").expect("it can be written");
    for command in [&words[..], &["plan", "specs/tocabi_squat_torque.toml"], &["cache", "list"]] {
        let (code, text) = told(&specforge(project.path(), command));
        assert!(
            code == 4 && text.contains("[E0813]") && text.contains("`walk.toml` does not belong"),
            "{text}"
        );
        assert!(text.contains("a folder that is empty or does not exist yet"), "{text}");
    }
    assert_eq!(files(project.path()).len(), 1);
    // What is put beside the folders of a store later stays.
    let mixed = folder();
    assert_eq!(told(&specforge(mixed.path(), &words)).0, 0);
    fs::write(mixed.path().join("b.jpg"), "x").expect("it can be written");
    assert_eq!(told(&specforge(mixed.path(), &words)).0, 0);
    fs::create_dir(mixed.path().join("damaged")).expect("a folder");
    fs::write(mixed.path().join("damaged/holiday.jpg"), "x").expect("it can be written");
    std::os::unix::fs::symlink(photos.path(), mixed.path().join("scratch").join(&key)).expect("a link");
    let (code, text) =
        told(&specforge(mixed.path(), &["cache", "gc", "--older-than", "0", "--scratch", "--force"]));
    assert_eq!(code, 0, "{text}");
    assert!(mixed.path().join("b.jpg").exists() && mixed.path().join("damaged/holiday.jpg").exists());
    assert_eq!(files(photos.path()), before);
}

#[test]
fn a_store_of_before_there_were_marks_stays_usable() {
    let (store, before, after) = superseded();
    fs::remove_file(store.path().join(".specforge-store")).expect("a mark");
    assert_eq!(
        gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).expect("it is recognised").waste.len(),
        6
    );
    fs::write(store.path().join("b.jpg"), "x").expect("it can be written");
    refused(store.path(), "E0813");
    let outcome = execute(&after, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    assert!(outcome.worked.is_empty());
    fs::remove_file(store.path().join("b.jpg")).expect("it is there");
    let mut third = arm("torque", "torque");
    set(&mut third, "reward.contact_force.weight", quantity(0.3, "0.3"), "--set");
    execute(&plan(&[third]), store.path(), &Fake::default(), 2).outcome.expect("the store works");
    assert!(store.path().join(".specforge-store").exists(), "it is marked when it is written");
    drop(before);
}

#[test]
fn a_store_whose_mark_is_damaged_or_of_another_layout_is_refused_by_every_command() {
    let (store, _, after) = superseded();
    let (mark, spec) = (store.path().join(".specforge-store"), "specs/tocabi_walk_torque.toml");
    let whole = fs::read_to_string(&mark).expect("a mark");
    for (text, words) in [
        (
            whole.replace("layout 1", "layout 2"),
            "its layout is 2, and this version of specforge knows only layout 1",
        ),
        (String::new(), "its mark `.specforge-store` is damaged"),
        (whole[..12].to_owned(), "its mark `.specforge-store` is damaged"),
    ] {
        fs::write(&mark, text).expect("it can be written");
        let before = files(store.path());
        for command in [
            &["cache", "gc", "--older-than", "0", "--force", "--scratch"][..],
            &["cache", "list"],
            &["cache", "verify"],
            &["plan", spec],
            &["why", spec, "learner"],
            &["run", spec, "--profile", "quick"],
            &["report", spec],
        ] {
            let (code, said) = told(&specforge(store.path(), command));
            assert!(
                code == 4 && said.contains("E0815") && said.contains(words),
                "{command:?}: {code} {said}"
            );
        }
        let error = execute(&after, store.path(), &Fake::default(), 2).outcome.expect_err("it is refused");
        assert_eq!(error.code(), Some("E0815"));
        assert_eq!(files(store.path()), before, "nothing was touched");
    }
    fs::remove_file(&mark).expect("it is there");
    assert!(gc::waste(&Store::at(store.path()), &ALL, &Wait::default()).is_ok());
}

// Policies.

#[test]
fn an_untrusted_policy_is_evaluated_only_on_request() {
    use specforge::learn::file;
    let place = folder();
    let bytes = fs::read("reports/policies/tocabi_walk_torque.safetensors").expect("it is committed");
    let (tensors, samples, mut header) = file::read_with(&bytes).expect("a policy");
    header.remove("digest");
    let texts: Vec<(&str, &str)> = header.iter().map(|(key, text)| (key.as_str(), text.as_str())).collect();
    let path = place.path().join("policy.safetensors");
    fs::write(&path, file::write_with(&tensors, &samples, &texts)).expect("it can be written");
    let path = path.to_string_lossy().into_owned();
    let words = ["evaluate", &path, "--episodes", "1", "--time-limit", "104 ms"];
    let (code, text) = told(&specforge(place.path(), &words));
    assert!(code == 4 && text.contains("[R0008]") && text.contains("--trust"), "{text}");
    let (code, text) = told(&specforge(place.path(), &[&words[..], &["--trust"]].concat()));
    assert_eq!(code, 0, "{text}");
}
