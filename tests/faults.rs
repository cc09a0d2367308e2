//! Faults at the command line: each has one clear error, the right exit code, and leaves the store usable.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

const SPEC: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/specs/atlas_run_torque.toml");

/// The command with a store of its own.
fn specforge(store: &Path) -> Command {
    let mut command = Command::cargo_bin("specforge").expect("the binary is built");
    command.arg("--store").arg(store).arg("--color").arg("never");
    command
}

/// A run of the stages that need no training.
fn quick_run(store: &Path) -> Command {
    let mut command = specforge(store);
    command.args(["run", SPEC, "--profile", "quick", "--until", "motion"]);
    command
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// The one artefact of a kind.
fn artefact(store: &Path, kind: &str) -> PathBuf {
    let mut entries = fs::read_dir(store.join(kind)).expect("the stage ran");
    entries.next().expect("an artefact").expect("an entry").path()
}

#[test]
fn a_run_works_once_and_the_next_finds_everything() {
    let store = folder();
    quick_run(store.path()).assert().success().stderr(contains("2 done"));
    quick_run(store.path()).assert().success().stderr(contains("2 cached"));
    specforge(store.path())
        .args(["cache", "verify"])
        .assert()
        .success()
        .stderr(contains("2 artefacts are whole"));
}

#[test]
fn a_changed_byte_is_told_moved_aside_and_made_anew() {
    let store = folder();
    quick_run(store.path()).assert().success();
    let file = artefact(store.path(), "motion").join("motion.json");
    let mut bytes = fs::read(&file).expect("a file");
    bytes[100] ^= 1;
    fs::write(&file, bytes).expect("it can be written");
    specforge(store.path()).args(["cache", "verify"]).assert().code(4).stderr(contains("R0003"));
    quick_run(store.path())
        .assert()
        .success()
        .stderr(contains("warning[R0003]: motion").and(contains("1 done, 1 cached")));
    quick_run(store.path()).assert().success().stderr(contains("2 cached"));
}

#[test]
fn a_store_that_cannot_be_written_is_one_error_with_its_code_and_exit_code_4() {
    let place = folder();
    let file = place.path().join("file");
    fs::write(&file, "not a folder").expect("it can be written");
    quick_run(&file)
        .assert()
        .code(4)
        .stderr(contains("[R0004] the store cannot be written").and(contains("--store DIR")));
}

#[test]
fn a_store_on_a_full_disk_is_r0004_and_usable_when_there_is_room_again() {
    let store = folder();
    // Files of at most one block: what a full disk does, without one.
    let binary = assert_cmd::cargo::cargo_bin("specforge");
    let command = format!(
        "trap '' XFSZ; ulimit -f 1; exec {} --store {} run {SPEC} --profile quick --until motion",
        binary.display(),
        store.path().display()
    );
    Command::new("sh").args(["-c", &command]).assert().code(4).stderr(
        contains("R0004")
            .and(contains("the limit on the size of a file is reached").and(contains("ulimit -f"))),
    );
    quick_run(store.path()).assert().success();
}

#[test]
fn why_names_the_field_both_values_and_where_they_come_from() {
    let store = folder();
    quick_run(store.path()).assert().success();
    specforge(store.path())
        .args(["why", SPEC, "robot", "--profile", "quick"])
        .assert()
        .success()
        .stdout(contains("would not run"));
    let set = ["why", SPEC, "robot", "--profile", "quick", "--set", "robot.payload=\"3 kg\""];
    let lines = ["robot.payload", "before: ", "now:    3 kg  (--set robot.payload="];
    let answer = specforge(store.path()).args(set).assert().success();
    let text = String::from_utf8_lossy(&answer.get_output().stdout).into_owned();
    assert!(lines.iter().all(|line| text.contains(line)), "{text}");
}

#[test]
fn a_plan_has_every_form_and_creates_no_store() {
    let place = folder();
    let store = place.path().join("none");
    let plan = |format: &str| {
        let output = specforge(&store)
            .args(["plan", SPEC, "--profile", "quick", "--format", format])
            .assert()
            .success();
        String::from_utf8_lossy(&output.get_output().stdout).into_owned()
    };
    assert!(plan("text").contains("shared by atlas_run_torque, atlas_run_position\n  robot "));
    assert!(plan("dot").starts_with("digraph plan {"));
    assert!(plan("mermaid").starts_with("flowchart LR"));
    let json: serde_json::Value = serde_json::from_str(&plan("json")).expect("JSON");
    let stages = json["stages"].as_array().expect("a list");
    assert_eq!(stages.iter().filter(|stage| stage["kind"] == "robot").count(), 1);
    assert_eq!(stages.iter().filter(|stage| stage["kind"] == "learner").count(), 2);
    assert!(!store.exists());
    specforge(&store).args(["check", SPEC, "--format", "dot"]).assert().code(2);
}

#[test]
fn a_stage_runs_by_itself_from_a_saved_plan_once_its_inputs_are_there() {
    let folder = folder();
    let (store, plan) = (folder.path().join("store"), folder.path().join("plan.json"));
    specforge(&store).args(["plan", SPEC, "--profile", "quick", "--save"]).arg(&plan).assert().success();
    let stage = |word: &str| {
        let mut command = specforge(&store);
        command.args(["stage", word, "--plan"]).arg(&plan);
        command
    };
    let advice = format!("--plan {}", plan.display());
    let told = stage("motion").assert().code(4).stderr(contains("its input `robot` is not in the store"));
    let told = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(told.contains("run it first: `specforge stage ") && told.contains(&advice), "{told}");
    assert!(!told.contains("--only") && !told.contains("--from"), "{told}");
    stage("robot").assert().success();
    stage("motion").assert().success();
    stage("learner").assert().code(2).stderr(contains("more than one stage"));
    fs::write(&plan, "{}").expect("it can be written");
    stage("robot").assert().code(2).stderr(contains("not a plan"));
}

#[test]
fn events_are_one_json_object_per_line() {
    let store = folder();
    let output = quick_run(store.path()).args(["--format", "json"]).assert().success();
    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    let events: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("JSON on every line")).collect();
    let names: Vec<&str> = events.iter().map(|event| event["event"].as_str().expect("a name")).collect();
    assert_eq!(names, ["stage_started", "stage_finished", "stage_started", "stage_finished", "run_finished"]);
    assert_eq!(events[4]["outcome"], "ok");
}

#[test]
fn words_that_name_no_stage_are_a_mistake_of_usage() {
    let store = folder();
    specforge(store.path())
        .args(["run", SPEC, "--only", "lerner"])
        .assert()
        .code(2)
        .stderr(contains("no stage is called `lerner`"));
    specforge(store.path()).args(["why", SPEC, "lerner"]).assert().code(2);
    specforge(store.path()).args(["run", SPEC, "--jobs", "0"]).assert().code(2);
    assert!(!store.path().join("robot").exists());
}

#[test]
fn specs_that_are_no_specs_stop_before_anything_runs() {
    let place = folder();
    let write = |name: &str, content: &[u8]| {
        let path = place.path().join(name);
        fs::write(&path, content).expect("it can be written");
        path
    };
    let files = [
        write("empty.toml", b""),
        write("binary.toml", &[0xff, 0xfe, 0x00, 0x80]),
        write("large.toml", &vec![b'#'; 10 << 20]),
        place.path().to_owned(),
        place.path().join("absent.toml"),
    ];
    for file in files {
        let ran = specforge(&place.path().join("store")).arg("run").arg(&file).assert().code(3);
        let text = String::from_utf8_lossy(&ran.get_output().stderr).into_owned();
        assert_eq!(text.matches("error[E0").count(), 1, "{}: {text}", file.display());
    }
    assert!(!place.path().join("store").exists());
}

#[test]
fn a_missing_template_is_found_before_anything_is_trained() {
    let store = folder();
    let set = ["run", SPEC, "--set", "report.template=\"rnu.md.j2\""];
    specforge(store.path()).args(set).assert().code(3).stderr(contains("E0901"));
}

/// A project with a spec `plain.toml`.
fn project() -> tempfile::TempDir {
    let place = folder();
    for name in ["robots", "specs", "templates"] {
        fs::create_dir(place.path().join(name)).expect("a folder");
    }
    let plain = ["new", "specs/plain.toml", "--robot", "atlas", "--task", "run", "--action", "torque"];
    specforge(&place.path().join("store")).current_dir(place.path()).args(plain).assert().code(0);
    place
}

/// Writes a spec that extends `plain.toml`.
fn child(project: &Path, name: &str, body: &str) {
    let text = format!("spec = 1\nextends = \"plain.toml\"\n{body}\n");
    fs::write(project.join("specs").join(name), text).expect("the folder can be written");
}

#[test]
fn templates_of_several_specs_do_not_share_the_limit_of_memory() {
    let place = project();
    // Each takes 60 MiB, all at once more than one may.
    let template = "{% set s = 'x' * 15000000 %}{% set t = s ~ s ~ s %}{{ t|length }}";
    for number in 0..10 {
        let file = place.path().join(format!("templates/own_{number}.j2"));
        fs::write(file, template).expect("the folder can be written");
        let body = format!("[report]\ntemplate = \"own_{number}.j2\"");
        child(place.path(), &format!("own_{number}.toml"), &body);
    }
    let mut check = specforge(&place.path().join("store"));
    check.current_dir(place.path()).args(["check", "specs"]).env("RAYON_NUM_THREADS", "10");
    check.assert().code(0).stderr(contains("11 specs: no errors, no warnings"));
}

#[test]
fn a_compared_spec_that_lacks_a_profile_is_named_where_it_is_listed() {
    let place = project();
    child(place.path(), "other.toml", "name = \"other\"");
    let profiles: String = (0..7).map(|number| format!("[profile.mine_{number}]\n")).collect();
    child(place.path(), "spec.toml", &format!("[report]\ncompare = [\"other.toml\"]\n{profiles}"));
    let check = |arguments: &[&str]| {
        let mut command = specforge(&place.path().join("store"));
        let found = command.current_dir(place.path()).args(arguments).assert().code(3);
        String::from_utf8_lossy(&found.get_output().stderr).into_owned()
    };
    let text = check(&["check", "specs/spec.toml"]);
    assert_eq!(text.matches("error[E0706]").count(), 1, "{text}");
    let named = "lacks the profiles `mine_0`, `mine_1`, `mine_2`, `mine_3` and `mine_4` and 2 more";
    assert!(text.contains(named) && text.contains("--> specs/spec.toml:4:12"), "{text}");
    let text = check(&["run", "specs/spec.toml", "--profile", "mine_0"]);
    assert!(text.contains("has no profile `mine_0`") && text.contains("--> specs/spec.toml:4:12"), "{text}");
}

#[test]
fn a_missing_baseline_does_not_hide_the_mistakes_of_compared_specs() {
    let place = project();
    child(place.path(), "other.toml", "name = \"other\"\n[action]\nrate = \"33 Hz\"");
    let body = "[report]\nbaseline = \"nothing.toml\"\ncompare = [\"other.toml\", \"other.toml\"]";
    child(place.path(), "spec.toml", body);
    let mut check = specforge(&place.path().join("store"));
    check.current_dir(place.path()).args(["check", "specs/spec.toml"]);
    let codes = ["E0004", "E0816", "E0501"].map(|code| contains(format!("error[{code}]")));
    let [missing, twice, compared] = codes;
    check.assert().code(3).stderr(missing.and(twice).and(compared));
}

#[test]
fn a_folder_of_reports_that_cannot_be_written_is_found_before_anything_runs() {
    let place = project();
    let mut run = specforge(&place.path().join("store"));
    run.current_dir(place.path()).args([
        "run",
        "specs/plain.toml",
        "--profile",
        "quick",
        "--reports",
        "/proc/x",
    ]);
    run.assert().code(2).stderr(contains("reports cannot be written into /proc/x"));
    assert!(!place.path().join("store").exists());
}

#[test]
fn a_suite_in_extends_is_named_where_it_is_extended() {
    let place = project();
    let suite = "spec = 1\nsuite = \"several\"\nextends = \"plain.toml\"\n[sweep]\nseeds = 2\n";
    fs::write(place.path().join("specs/several.toml"), suite).expect("the folder can be written");
    let spec = "spec = 1\nname = \"own\"\nextends = \"several.toml\"\n";
    fs::write(place.path().join("specs/own.toml"), spec).expect("the folder can be written");
    let mut check = specforge(&place.path().join("store"));
    check.current_dir(place.path()).args(["check", "specs/own.toml"]);
    let told =
        contains("error[E0606]: `specs/several.toml` is a suite").and(contains("--> specs/own.toml:3:11"));
    check.assert().code(3).stderr(told.and(contains("1 error;")));
}

#[test]
fn a_template_that_works_without_an_end_is_stopped_by_the_clock() {
    let place = project();
    let sorts = "{% set x = range(100000)|list %}{% for i in range(100000) %}{{ x|sort|length }}{% endfor %}";
    fs::write(place.path().join("templates/slow.j2"), sorts).expect("the folder can be written");
    child(place.path(), "slow.toml", "[report]\ntemplate = \"slow.j2\"");
    let mut check = specforge(&place.path().join("store"));
    check.current_dir(place.path()).args(["check", "specs/slow.toml"]);
    let told =
        contains("error[E0905]: rendering takes more than 20 s").and(contains("--> specs/slow.toml:4:12"));
    check.assert().code(3).stderr(told);
}
