//! `specforge fmt` from outside, and the canonical form of every committed file.

use std::fs;
use std::io::Write;
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

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn piped(arguments: &[&str], input: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program can be started");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("the program reads");
    child.wait_with_output().expect("the program ends")
}

#[test]
fn every_committed_spec_motion_and_robot_is_in_its_canonical_form() {
    let output = specforge(&["fmt", "--check", "specs", "robots"]);
    assert_eq!(code(&output), 0, "{}{}", text(&output.stdout), text(&output.stderr));
    assert_eq!(text(&output.stdout), "");
    let count = toml_files(&root().join("specs")).len() + toml_files(&root().join("robots")).len();
    assert!(text(&output.stderr).contains(&format!("{count} already in order")), "{}", text(&output.stderr));
}

fn toml_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for path in fs::read_dir(folder).expect("the folder is there").flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(toml_files(&path));
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            found.push(path);
        }
    }
    found
}

const UNTIDY: &str = "name=\"a\"\nspec=1\n[learn]\nseed=2 # lucky\nkind=\"ppo\"\n";

const TIDY: &str = "spec = 1\nname = \"a\"\n\n[learn]\nkind = \"ppo\"\nseed = \
    2                                      # lucky\n";

#[test]
fn check_prints_the_difference_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.toml");
    fs::write(&path, UNTIDY).expect("written");
    let file = path.to_string_lossy().into_owned();
    let output = specforge(&["fmt", "--check", &file]);
    assert_eq!(code(&output), 3);
    let difference = text(&output.stdout);
    assert!(difference.contains("-spec=1\n") && difference.contains("+kind = \"ppo\"\n"), "{difference}");
    assert_eq!(fs::read_to_string(&path).expect("it is there"), UNTIDY);
    let json: serde_json::Value =
        serde_json::from_slice(&specforge(&["fmt", "--check", "--format", "json", &file]).stdout)
            .expect("JSON");
    assert_eq!((&json["changed"], &json["errors"]), (&serde_json::json!([file]), &serde_json::json!(0)));
}

#[test]
fn files_are_rewritten_in_place_with_their_permissions_and_through_links() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let (path, link) = (folder.path().join("a.toml"), folder.path().join("link.toml"));
    fs::write(&path, UNTIDY).expect("written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("the mode is set");
    std::os::unix::fs::symlink(&path, &link).expect("a link");
    assert_eq!(code(&specforge(&["fmt", &link.to_string_lossy()])), 0);
    assert_eq!(fs::read_to_string(&path).expect("it is there"), TIDY);
    assert_eq!(fs::metadata(&path).expect("it is there").permissions().mode() & 0o777, 0o640);
    assert!(fs::symlink_metadata(&link).expect("it is there").file_type().is_symlink());
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "no temporary file is left");
}

#[test]
fn what_is_no_toml_is_reported_and_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let (broken, sound) = (folder.path().join("broken.toml"), folder.path().join("sound.toml"));
    fs::write(&broken, "spec = 1\n[learn\n").expect("written");
    fs::write(&sound, UNTIDY).expect("written");
    fs::write(folder.path().join("Cargo.toml"), "[package]\nname=\"x\"\n").expect("written");
    let output = specforge(&["fmt", &folder.path().to_string_lossy()]);
    assert_eq!(code(&output), 3);
    assert!(text(&output.stderr).contains("error[E0001]"), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(&broken).expect("it is there"), "spec = 1\n[learn\n");
    assert_eq!(
        fs::read_to_string(&sound).expect("it is there"),
        TIDY,
        "the others are formatted all the same"
    );
    let other = fs::read_to_string(folder.path().join("Cargo.toml")).expect("it is there");
    assert_eq!(other, "[package]\nname=\"x\"\n", "a file of someone else in a folder is left alone");
}

#[test]
fn standard_input_goes_to_standard_output() {
    let output = piped(&["fmt", "-"], UNTIDY);
    assert_eq!((code(&output), text(&output.stdout).as_str()), (0, TIDY));
    assert_eq!(text(&piped(&["fmt", "-"], TIDY).stdout), TIDY);
    assert_eq!(code(&piped(&["fmt", "--check", "-"], UNTIDY)), 3);
    let broken = piped(&["fmt", "-"], "a = \n");
    assert_eq!((code(&broken), text(&broken.stdout).as_str()), (3, ""));
    assert!(text(&broken.stderr).contains("E0001"));
}

#[test]
fn what_show_resolved_prints_is_in_its_canonical_form() {
    let resolved = text(&specforge(&["show", "--resolved", "specs/atlas_run_position.toml"]).stdout);
    assert_eq!(code(&piped(&["fmt", "--check", "-"], &resolved)), 0);
}
