//! The inspecting commands from outside: exit codes, standard output and standard error.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn specforge(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(root()).args(arguments).output().expect("the program can be started")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ends by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The specs of the project, without their parents.
fn specs() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("specs")).expect("specs/ is there").flatten().map(|entry| entry.path());
    entries.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect()
}

#[test]
fn every_spec_of_the_project_is_in_order() {
    let output = specforge(&["check", "specs", "--deny", "warnings"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output), "", "messages are no data");
}

#[test]
fn what_is_wrong_with_a_file_has_a_code_and_ends_with_3() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| {
        fs::write(folder.path().join(name), bytes).expect("files can be written");
        folder.path().join(name)
    };
    let cases = [
        (folder.path().join("absent.toml"), "E0004"),
        (write("empty.toml", b""), "E0002"),
        (write("binary.toml", &[0xff, 0xfe, 0x00, 0x80]), "E0005"),
        (write("huge.toml", &vec![b'#'; 10 << 20]), "E0006"),
        (write("broken.toml", b"spec = 1\n[action\n"), "E0001"),
    ];
    for (path, expected) in cases {
        let output = specforge(&["check", "--format", "json", &path.to_string_lossy()]);
        assert_eq!(code(&output), 3, "{}", path.display());
        let document: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("the document is JSON");
        assert_eq!(document["errors"], 1, "{document}");
        assert_eq!(document["diagnostics"][0]["code"], expected, "{document}");
    }
}

#[test]
fn a_folder_without_specs_and_wrong_arguments_end_with_2() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_eq!(code(&specforge(&["check", &folder.path().to_string_lossy()])), 2);
    assert_eq!(code(&specforge(&["check"])), 2);
    assert_eq!(code(&specforge(&["chek", "specs"])), 2);
    assert_eq!(code(&specforge(&["show", "--diff", "specs/atlas_run_torque.toml"])), 2);
    assert_eq!(code(&specforge(&["explain", "E9999"])), 2);
    assert_eq!(code(&specforge(&["--help"])), 0);
}

#[test]
fn codes_kinds_and_units_are_explained() {
    assert!(stdout(&specforge(&["explain", "e0203"])).starts_with("# E0203: unit mismatch"));
    let torque = stdout(&specforge(&["explain", "torque"]));
    assert!(torque.contains("# action.torque") && torque.contains("# reward.torque"), "one word, two kinds");
    assert!(stdout(&specforge(&["explain", "ms"])).contains("1 ms is 0.001 s."));
    assert!(stderr(&specforge(&["explain", "velocity_trackin"])).contains("did you mean `velocity_tracking`?"));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let started = command.arg("list").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = started.expect("the program can be started");
    drop(child.stdout.take());
    let mut complaints = String::new();
    child.stderr.take().expect("stderr is piped").read_to_string(&mut complaints).expect("messages are text");
    assert!(child.wait().expect("the program ends").success(), "{complaints}");
    assert_eq!(complaints, "");
}

#[test]
fn a_resolved_spec_describes_the_same_experiment() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy(&root().join("specs"), folder.path());
    for spec in specs() {
        let name = spec.file_name().expect("a spec has a name");
        let original = folder.path().join(name);
        for variant in [&["--set", "learn.seed=7"][..], &["--profile", "quick"][..]] {
            let file = original.to_string_lossy();
            let shown = [&["show", "--resolved", &file][..], variant].concat();
            let resolved = folder.path().join(format!("resolved_{}", name.to_string_lossy()));
            fs::write(&resolved, stdout(&specforge(&shown))).expect("files can be written");
            let values = |path: &Path, variant: &[&str]| {
                let file = path.to_string_lossy();
                let arguments = ["show", "--resolved", "--format", "json", &file];
                let output = specforge(&[&arguments[..], variant].concat());
                assert_eq!(code(&output), 0, "{}", stderr(&output));
                stdout(&output)
            };
            assert_eq!(values(&resolved, &[]), values(&original, variant), "{}", spec.display());
        }
    }
}

fn copy(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).expect("the folder is readable").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            fs::create_dir_all(&target).expect("folders can be made");
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("files can be copied");
        }
    }
}

#[test]
fn origins_name_file_profile_argument_and_default() {
    let arguments = ["show", "--origins", "specs/atlas_run_torque.toml", "--profile", "quick", "--set", "learn.seed=3"];
    let shown = stdout(&specforge(&arguments));
    let origin = |path: &str| {
        let line = shown.lines().find(|line| line.starts_with(&format!("{path} = "))).expect("the value is shown");
        line.rsplit_once("  ").expect("an origin stands behind two spaces").1.to_owned()
    };
    assert!(origin("action.std").starts_with("specs/base/torque.toml:"));
    assert!(origin("action.delay").starts_with("profile quick, specs/base/biped.toml:"));
    assert_eq!(origin("learn.seed"), "--set learn.seed=3");
    assert_eq!(origin("learn.max_grad_norm"), "default");
}

#[test]
fn signals_are_thirty_inputs_and_thirteen_outputs_in_joint_order() {
    let output = specforge(&["show", "--signals", "--format", "json", "specs/tocabi_walk_torque.toml"]);
    let document: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("the document is JSON");
    let (inputs, outputs) = (&document["inputs"], &document["outputs"]);
    assert_eq!(inputs.as_array().map(Vec::len), Some(30));
    assert_eq!(outputs.as_array().map(Vec::len), Some(13));
    assert_eq!((&inputs[3]["signal"], &inputs[3]["joint"]), (&"joint_position".into(), &"L_HipYaw_Joint".into()));
    assert_eq!((&inputs[29]["signal"], &inputs[29]["unit"]), (&"command_speed".into(), &"m/s".into()));
    assert_eq!(outputs[3]["range"], serde_json::json!([-289.0, 289.0]));
    assert_eq!(document["law"], "tau = clamp(effort_limit * a, +-effort_limit), held for 4 ms, delayed 2..6 ms");
}

#[test]
fn a_diff_names_the_values_in_which_two_specs_differ() {
    let shown = stdout(&specforge(&["show", "--diff", "specs/atlas_run_torque.toml", "specs/atlas_run_position.toml"]));
    assert!(shown.contains("action.kind\n  - \"torque\""), "{shown}");
    assert!(!shown.contains("physics"), "what is shared is not shown: {shown}");
}
