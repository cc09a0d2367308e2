//! Commands replace only files that they wrote themselves.

use std::fs;
use std::path::Path;
use std::process::Command;

const SPEC: &str = "specs/tocabi_walk_torque.toml";

/// Runs a command in the root of the repository; its exit code and its messages.
fn told(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_specforge"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .expect("specforge can be started");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A command refuses to replace a file of the user with this name, and replaces nothing.
#[track_caller]
fn refuses(path: &Path, arguments: &[&str]) {
    let mine = "name = \"mine\"\n";
    fs::write(path, mine).expect("it can be written");
    let before = names(path.parent().expect("a folder"));
    let (code, text) = told(arguments);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("exists and is not") && text.contains("help:"), "{text}");
    assert_eq!(fs::read_to_string(path).expect("it is there"), mine, "{text}");
    assert_eq!(names(path.parent().expect("a folder")), before);
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into()).collect();
    names.sort();
    names
}

#[test]
fn a_plan_replaces_only_a_plan() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, store) = (folder.path().join("other.toml"), folder.path().join("store"));
    let (file, store) = (path.display().to_string(), store.display().to_string());
    let plan = ["plan", SPEC, "--profile", "quick", "--store", &store, "--save", &file];
    refuses(&path, &plan);
    // Any JSON file is not a plan.
    fs::write(&path, "{\"arms\": [], \"stages\": [], \"report\": \"walk\"}").expect("it can be written");
    assert_eq!(told(&plan).0, Some(2));
    for content in ["", "{\"arms\": [], \"stages\": []}"] {
        fs::write(&path, content).expect("it can be written");
        for _ in 0..2 {
            let (code, text) = told(&plan);
            assert_eq!(code, Some(0), "{text}");
        }
        assert!(fs::read_to_string(&path).expect("a plan").contains("\"digests\""));
    }
}

#[test]
fn schemas_an_index_and_records_replace_only_their_own_kind() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().display().to_string();
    let schema = ["schema", "--write", &place];
    assert_eq!(told(&schema).0, Some(0));
    assert_eq!(told(&schema).0, Some(0), "its own files are replaced");
    let written = names(folder.path());
    let last = written.last().expect("a schema");
    refuses(&folder.path().join(last), &schema);

    let reports = tempfile::tempdir().expect("a folder");
    let place = reports.path().display().to_string();
    refuses(&reports.path().join("README.md"), &["report", "--index", "--reports", &place]);
    fs::remove_file(reports.path().join("README.md")).expect("it is there");
    for _ in 0..2 {
        let (code, text) = told(&["report", "--index", "--reports", &place]);
        assert_eq!(code, Some(0), "{text}");
    }
}
