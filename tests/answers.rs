//! What programs get when a command fails: with `--format json` one document on standard output, in the form
//! of `check`, whatever fails, and nothing but JSON on standard error. And exit codes that agree between
//! commands.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const SPEC: &str = "specs/atlas_run_torque.toml";

fn specforge(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["--color", "never"]).args(arguments);
    command.output().expect("it starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// The exit code and the first diagnostic of a command that fails.
#[track_caller]
fn failed(arguments: &[&str]) -> (i32, Value) {
    let output = specforge(&[arguments, &["--format", "json"]].concat());
    let (out, told) = (text(&output.stdout), text(&output.stderr));
    let document: Value =
        serde_json::from_str(&out).unwrap_or_else(|error| panic!("{arguments:?}: {error}: {out}{told}"));
    for line in told.lines() {
        assert!(serde_json::from_str::<Value>(line).is_ok(), "{arguments:?}: {line}");
    }
    let diagnostic = document["diagnostics"][0].clone();
    assert!(
        diagnostic["message"].as_str().is_some_and(|message| !message.is_empty()),
        "{arguments:?}: {out}"
    );
    assert!(diagnostic["help"].is_array() && document["errors"].as_u64() >= Some(1), "{arguments:?}: {out}");
    (output.status.code().expect("an exit code"), diagnostic)
}

fn policy() -> String {
    let folder =
        std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/policies")).expect("policies");
    let mut paths: Vec<_> = folder.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "safetensors"));
    paths.sort();
    paths.first().expect("a policy").display().to_string()
}

#[test]
fn every_failure_is_one_document_for_programs() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (store, absent, file) = (at("store"), at("absent"), at("file.toml"));
    std::fs::write(&file, "spec = 1").expect("written");
    let text = at("text");
    std::fs::write(&text, "no policy").expect("written");
    let policy = policy();
    let cases: &[(&[&str], i32, Option<&str>)] = &[
        (&["why", SPEC, "nope", "--store", &store], 2, None),
        (&["run", SPEC, "--only", "nope", "--store", &store], 2, None),
        (&["run", SPEC, "--reports", &file, "--store", &store], 2, None),
        (&["run", "--nonsense"], 2, None),
        (&["nonsense"], 2, None),
        (&["plan", SPEC, "--save", "/nonexistent/plan.json", "--store", &store], 4, None),
        (&["stage", "robot", "--plan", &at("plan.json")], 3, Some("E0004")),
        (&["run", &at("plan.json")], 3, Some("E0004")),
        (&["trace", "nofile.svg"], 3, Some("E0004")),
        (&["check", &at("nothing.toml")], 3, Some("E0004")),
        (&["evaluate", &at("nothing.safetensors")], 3, Some("E0004")),
        (&["evaluate", &text], 4, Some("R0002")),
        (&["evaluate", &file], 3, Some("E0101")),
        (&["list", "nope"], 2, None),
        (&["explain", "nope"], 2, None),
        (&["robot", "show", "nope"], 2, None),
        (&["new", &file], 2, None),
        (&["cache", "verify", "--store", &absent], 4, Some("E0813")),
        (&["cache", "list", "--store", &absent], 4, Some("E0813")),
        (&["cache", "list", "--store", &file], 2, None),
        (&["evaluate", &policy, "--seed", "-1"], 3, Some("E0204")),
        (&["evaluate", &policy, "--rate", "-5Hz"], 3, Some("E0204")),
        (&["bench", SPEC, "--jobs", "-1"], 2, None),
    ];
    for (arguments, exit, code) in cases {
        let (found, diagnostic) = failed(arguments);
        assert_eq!((found, diagnostic["code"].as_str()), (*exit, *code), "{arguments:?}: {diagnostic}");
    }
}

/// Before, memory ran out: the size was held to bounds in specs alone.
#[test]
fn a_ground_of_an_option_is_held_to_the_bounds_of_a_spec() {
    let policy = policy();
    for (size, of) in
        [("cell=1 cm,length=1000 m,width=1000 m", "100001 by 100001"), ("cell=10 m,length=4 m", "of 4 m")]
    {
        let ground = format!("height_field,amplitude=2 cm,{size}");
        let (exit, found) = failed(&["evaluate", &policy, "--episodes", "1", "--terrain", &ground]);
        assert_eq!((exit, &found["code"]), (3, &"E0204".into()), "{found}");
        assert!(found["message"].as_str().is_some_and(|message| message.contains(of)), "{found}");
    }
}

#[test]
fn no_advice_for_arguments_is_one_that_does_not_work() {
    for arguments in [&["bench", SPEC, "--jobs", "-1"][..], &["robot", "import", "-1"], &["run", SPEC, "-1"]]
    {
        let output = specforge(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let told = text(&output.stderr);
        assert!(told.starts_with("error: ") && !told.contains("-- -1"), "{told}");
    }
}

#[test]
fn absurd_numbers_are_out_of_range_with_both_bounds_and_few_digits() {
    let huge = format!("1{}", "0".repeat(308));
    let cases = [
        ("reward.torque.weight", "1e308", "between -1000000 and 1000000"),
        ("reward.torque.weight", huge.as_str(), "between -1000000 and 1000000"),
        ("reward.torque.k", "5e-324 /N/m", "between 0.000000001 /N/m and 1000000000 /N/m"),
        ("task.command.speed", "1e300 m/s", "between -10 m/s and 10 m/s"),
        (
            "observe.joint_position.noise",
            "{normal=[\"0 rad\",\"1e300 rad\"]}",
            "between -3.2 rad and 3.2 rad",
        ),
        (
            "observe.joint_position.noise",
            "{uniform=[\"-1e308 rad\",\"1e308 rad\"]}",
            "between -3.2 rad and 3.2 rad",
        ),
        ("observe.joint_position.clip", "1e-300", "between 0.001 and 1000000"),
        ("learn.clip", "5e-324", "between 0.001 and 10"),
        ("learn.samples", "9223372036854775807", "between 0 and 1000000000000"),
        ("learn.samples", "9999999999 G", "between 0 and 1000000000000"),
        ("learn.seed", "-1", "between 0 and 9223372036854775807"),
    ];
    for (path, value, bounds) in cases {
        let output = specforge(&["check", SPEC, "--set", &format!("{path}={value}")]);
        let told = text(&output.stderr);
        assert!(
            told.contains("error[E0204]") && told.contains(&format!("it must be {bounds}")),
            "{path} {value}: {told}"
        );
        let message = told.lines().find(|line| line.starts_with("error[E0204]")).expect("the message");
        assert!(message.len() < 120, "{message}");
    }
}
