//! Checking as an editor calls it: texts that are not on the disk, over files that are, or over nothing at
//! all.

use std::fs;
use std::path::{Path, PathBuf};

use specforge::check::{Checked, checked, checked_in};
use specforge::spec::LoadOptions;
use specforge::syntax::{Disk, Nowhere, Overlay};

fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// What was found, as `CODE FILE:LINE:COLUMN`, files without their folders.
fn found(checked: &Checked) -> Vec<String> {
    let one = |diagnostic: &specforge::diag::Diagnostic| {
        let place =
            diagnostic.labels.first().map(|label| checked.sources.place(label.span)).unwrap_or_default();
        format!("{} {}", diagnostic.code, place.rsplit('/').next().unwrap_or_default())
    };
    checked.sink.diagnostics.iter().map(one).collect()
}

#[test]
fn a_text_that_is_not_saved_is_checked_in_place_of_its_file() {
    let path = repository("specs/tocabi_walk_torque.toml");
    let saved = fs::read_to_string(&path).expect("the spec is readable");
    let mut files = Overlay::new(Disk);
    files.hold(&path, format!("{saved}\n[action]\ndelay = 0.004\n"));
    let line = saved.lines().count() + 3;
    let options = LoadOptions::default();
    assert_eq!(
        found(&checked_in(&files, &path, &options)),
        [format!("E0201 tocabi_walk_torque.toml:{line}:9")]
    );
    assert_eq!(found(&checked(&path, &options)), Vec::<String>::new(), "the file itself is as it was");
    files.release(&path);
    assert_eq!(found(&checked_in(&files, &path, &options)), Vec::<String>::new());
}

#[test]
fn a_parent_that_is_not_saved_counts_for_its_children() {
    let parent = repository("specs/base/task/walk.toml");
    let text = fs::read_to_string(&parent).expect("the parent is readable");
    let wrong = text.replace("\"walk\"", "\"wakl\"");
    assert_ne!(text, wrong);
    let mut files = Overlay::new(Disk);
    files.hold(&parent, wrong);
    let checked = checked_in(&files, &repository("specs/tocabi_walk_torque.toml"), &LoadOptions::default());
    let found = found(&checked);
    assert!(
        !found.is_empty() && found.iter().all(|found| found.starts_with("E0301 walk.toml:")),
        "{found:?}"
    );
}

#[test]
fn a_world_in_memory_needs_no_disk() {
    let mut files = Overlay::new(Nowhere);
    let whole =
        fs::read_to_string(repository("tests/language/whole.toml")).expect("the complete spec is readable");
    files.hold(Path::new("specs/whole.toml"), whole);
    files.hold(Path::new("specs/run.toml"), "spec = 1\nname = \"run\"\nextends = \"whole.toml\"\n");
    let options = LoadOptions::default();
    let right = checked_in(&files, Path::new("specs/run.toml"), &options);
    assert_eq!(found(&right), Vec::<String>::new());
    assert!(
        right.sound().is_some_and(|(experiment, robot)| experiment.name == "run" && robot.name == "tocabi")
    );

    files.hold(
        Path::new("specs/run.toml"),
        "spec = 1\nextends = \"whoel.toml\"\n[report]\ncompare = [\"no.toml\"]\n",
    );
    let wrong = checked_in(&files, Path::new("specs/run.toml"), &options);
    assert_eq!(found(&wrong), ["E0601 run.toml:2:11", "E0004 run.toml:4:12"]);
    assert_eq!(wrong.sink.diagnostics[0].help, ["there is a file `whole.toml` in that folder"]);

    let missing = checked_in(&files, Path::new("specs/rnu.toml"), &options);
    assert_eq!((missing.sink.diagnostics.len(), missing.sink.diagnostics[0].code), (1, "E0004"));
}

#[test]
fn a_robot_that_is_not_saved_is_the_robot_of_its_specs() {
    let robot = fs::read_to_string(repository("robots/tocabi.toml")).expect("the robot is readable");
    let mut files = Overlay::new(Nowhere);
    let whole =
        fs::read_to_string(repository("tests/language/whole.toml")).expect("the complete spec is readable");
    files.hold(Path::new("specs/whole.toml"), whole.replace("\"tocabi\"", "\"mine\""));
    files.hold(Path::new("robots/mine.toml"), robot.replace("name = \"tocabi\"", "name = \"mine\""));
    let right = checked_in(&files, Path::new("specs/whole.toml"), &LoadOptions::default());
    assert_eq!(found(&right), Vec::<String>::new());
    files.hold(Path::new("robots/mine.toml"), robot.replacen("effort_limit", "effort_limti", 1));
    let wrong = checked_in(&files, Path::new("specs/whole.toml"), &LoadOptions::default());
    let found = found(&wrong);
    assert!(
        found.iter().all(|found| found.starts_with("E0102 mine.toml:")) && !found.is_empty(),
        "{found:?}"
    );
}
