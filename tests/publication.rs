//! What is written is written whole: full disks, symbolic links and paths that lead out of their folder.

mod arms;
#[path = "report/made_up_work.rs"]
mod made_up_work;
#[path = "report/synthetic.rs"]
mod synthetic;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use specforge::exec::events::Record;
use specforge::exec::{self, Interrupt, Store, Work, Works, Workshop};
use specforge::plan::{Plan, StageKind};
use specforge::report::{ReportWork, Templates};

const SPEC: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/specs/atlas_run_torque.toml");

/// The command in a folder, where no file can grow beyond so many blocks of `ulimit -f`: what a full disk
/// does.
fn limited(folder: &Path, blocks: usize, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.current_dir(folder).args(["-c", &format!("ulimit -f {blocks}; exec \"$0\" \"$@\"")]);
    command
        .arg(env!("CARGO_BIN_EXE_specforge"))
        .args(["--color", "never"])
        .args(arguments)
        .output()
        .expect("it starts")
}

fn specforge(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(folder).args(["--color", "never"]).args(arguments).output().expect("it starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a folder with its content.
fn content(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fn walk(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
        for path in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            match path.is_dir() {
                true => walk(&path, found),
                false => drop(found.insert(path.clone(), fs::read(&path).expect("a file"))),
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(root, &mut found);
    found
}

/// A folder with the plan of one made-up arm in `plan.json` and all its stages in `store`.
fn finished() -> (tempfile::TempDir, Plan) {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = arms::plan(&[arms::arm("atlas_run_torque", "torque")]);
    let mut works: Works = StageKind::ALL
        .into_iter()
        .map(|kind| (kind, Box::new(made_up_work::MadeUp) as Box<dyn Work>))
        .collect();
    let report = ReportWork::new(Templates::default(), |_| Some("tau = a".to_string()));
    works.insert(StageKind::Report, Box::new(report));
    let (store, record, interrupt) =
        (Store::at(folder.path().join("store")), Record::default(), Interrupt::default());
    let workshop =
        Workshop { plan: &plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
    let outcome = exec::run(&workshop, &arms::options(&plan, 2)).expect("the store works");
    assert!(outcome.report.is_some() && outcome.failures.is_empty());
    fs::write(folder.path().join("plan.json"), serde_json::to_string(&plan).expect("plain data"))
        .expect("written");
    (folder, plan)
}

const PUBLISH: &[&str] = &["--store", "store", "report", "plan.json", "--reports", "reports"];

#[test]
fn a_full_disk_leaves_the_earlier_report_whole_at_whatever_byte_it_strikes() {
    let (folder, _) = finished();
    let reports = folder.path().join("reports");
    let first = specforge(folder.path(), PUBLISH);
    assert!(first.status.success(), "{}", said(&first));
    let new = content(&reports);
    assert!(new.len() > 4, "a page, a record and figures: {:?}", new.keys());
    // An earlier report of the same run: another page and other figures.
    let is_record = |path: &Path| path.extension().is_some_and(|ending| ending == "json");
    let mut old = new.clone();
    for (path, bytes) in old.iter_mut().filter(|(path, _)| !is_record(path)) {
        *bytes = b"earlier".to_vec();
        fs::write(path, &bytes).expect("written");
    }
    let (mut failed, mut blocks) = (0, 0);
    loop {
        let output = limited(folder.path(), blocks, PUBLISH);
        let mut found = content(&reports);
        if output.status.success() {
            // What was not as it had been rendered is kept beside the new files.
            let is_copy = |path: &Path| path.extension().is_some_and(|ending| ending == "edited");
            let copies: Vec<Vec<u8>> =
                found.extract_if(.., |path, _| is_copy(path)).map(|(_, bytes)| bytes).collect();
            assert!(!copies.is_empty() && copies.iter().all(|bytes| bytes == b"earlier"), "{blocks} blocks");
            assert!(found == new, "{blocks} blocks: {:?}", found.keys());
            break;
        }
        assert_eq!(output.status.code(), Some(4), "{blocks} blocks: {}", said(&output));
        assert!(said(&output).contains("[R0004] the report cannot be written"), "{}", said(&output));
        assert!(found == old, "{blocks} blocks: {:?}", found.keys());
        (failed, blocks) = (failed + 1, blocks + 8);
        assert!(blocks < 10_000, "it never works");
    }
    assert!(failed > 2, "the disk was full {failed} times");
}

#[test]
fn commands_that_write_a_file_leave_the_old_one_or_none_when_the_disk_is_full() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let unformatted = format!(
        "spec    = 1\nname = \"walk\"\n{}",
        "# a line of a comment that takes its place\n".repeat(200)
    );
    fs::write(at("walk.toml"), &unformatted).expect("written");
    fs::write(at("plan.json"), "{\"arms\": [], \"stages\": []}").expect("written");
    fs::create_dir_all(at("schema")).expect("a folder");
    fs::create_dir_all(at("specs/studies")).expect("a folder");
    fs::write(at("schema/spec-1.json"), "{\"$schema\": \"of before\"}").expect("written");
    let before = content(folder.path());
    let plan = ["plan", SPEC, "--profile", "quick", "--save", "plan.json"];
    let commands: [&[&str]; 4] = [
        &["fmt", "walk.toml"],
        &plan,
        &["schema", "--write", "schema"],
        &["new", "fresh.toml", "--standalone"],
    ];
    for command in commands {
        let output = limited(folder.path(), 1, command);
        assert!(!output.status.success(), "{command:?}");
        assert!(said(&output).contains("error"), "{command:?}: {}", said(&output));
        let after = content(folder.path());
        assert!(after == before, "{command:?}: {:?}", after.keys());
        let output = specforge(folder.path(), command);
        assert!(output.status.success(), "{command:?}: {}", said(&output));
        content(folder.path()).keys().for_each(|path| drop(fs::remove_file(path)));
        before.iter().for_each(|(path, bytes)| fs::write(path, bytes).expect("written"));
    }
}

#[test]
fn the_index_of_before_stays_when_the_disk_is_full() {
    let (folder, root) = (tempfile::tempdir().expect("a folder"), Path::new(env!("CARGO_MANIFEST_DIR")));
    let page = folder.path().join("README.md");
    let before = "# Reports\n\nWhat was claimed and what became of it, suite by suite.\n";
    fs::write(&page, before).expect("written");
    let reports = folder.path().display().to_string();
    let output = limited(root, 1, &["report", "--index", "--reports", &reports]);
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    assert_eq!(content(folder.path()), BTreeMap::from([(page, before.as_bytes().to_vec())]));
}

/// A run of the stages that need no training.
fn quick_run(folder: &Path) -> Output {
    specforge(folder, &["--store", "store", "run", SPEC, "--profile", "quick", "--until", "motion"])
}

#[test]
fn a_link_inside_a_store_is_named_and_nothing_behind_it_is_touched() {
    for name in ["tmp", "scratch", "locks", "robot", "motion", "journal.jsonl"] {
        for target in ["elsewhere", "elsewhere/nothing"] {
            let folder = tempfile::tempdir().expect("a folder");
            fs::create_dir_all(folder.path().join("store")).expect("a folder");
            fs::create_dir_all(folder.path().join("elsewhere")).expect("a folder");
            symlink(folder.path().join(target), folder.path().join("store").join(name)).expect("a link");
            let output = quick_run(folder.path());
            assert_eq!(output.status.code(), Some(4), "{name}: {}", said(&output));
            let told = said(&output);
            assert!(
                told.contains("[R0011]") && told.contains(&format!("store/{name} is a symbolic link")),
                "{told}"
            );
            assert_eq!(content(&folder.path().join("elsewhere")).len(), 0, "{name}");
        }
    }
}

#[test]
fn the_store_itself_may_be_a_link() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir_all(folder.path().join("elsewhere")).expect("a folder");
    symlink("elsewhere", folder.path().join("store")).expect("a link");
    let output = quick_run(folder.path());
    assert!(output.status.success(), "{}", said(&output));
    assert!(folder.path().join("elsewhere/motion").is_dir());
}

#[test]
fn a_link_in_place_of_an_artefacts_file_counts_as_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(quick_run(folder.path()).status.success());
    let motions = fs::read_dir(folder.path().join("store/motion")).expect("a folder");
    let motion =
        motions.map(|entry| entry.expect("an entry").path()).next().expect("the motion").join("motion.json");
    fs::rename(&motion, folder.path().join("moved.json")).expect("moved");
    symlink(folder.path().join("moved.json"), &motion).expect("a link");
    let output = quick_run(folder.path());
    let told = said(&output);
    assert!(
        output.status.success() && told.contains("warning[R0003]") && told.contains("is a symbolic link"),
        "{told}"
    );
}

#[test]
fn a_saved_plan_names_no_files_outside_of_its_folders() {
    let (folder, plan) = finished();
    let text = serde_json::to_string(&plan).expect("plain data");
    for name in ["../../outside", "/tmp/outside", ".hidden", "a/b"] {
        let json = text.replace(
            "\"arm\":\"atlas_run_torque\",\"stage\":\"report\"",
            &format!("\"arm\":\"{name}\",\"stage\":\"report\""),
        );
        assert_ne!(json, text);
        fs::write(folder.path().join("plan.json"), json).expect("written");
        let output = specforge(folder.path(), PUBLISH);
        assert_eq!(output.status.code(), Some(3), "{name}: {}", said(&output));
        assert!(said(&output).contains("error[E0811]"), "{}", said(&output));
    }
    let key = plan.stages().next().expect("a stage").fingerprint.to_string();
    fs::write(folder.path().join("plan.json"), text.replace(&key, "../../outside")).expect("written");
    let output = specforge(folder.path(), PUBLISH);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("a key has 64 hexadecimal digits"), "{}", said(&output));
}
