//! A report takes the place of a page of the same run, and stands beside a page of another one.

mod arms;
#[path = "report/made_up_work.rs"]
mod made_up_work;
#[path = "report/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use specforge::exec::events::Record;
use specforge::exec::{self, Interrupt, Store, Work, Works, Workshop};
use specforge::plan::{Arm, Request, StageKind, SuiteRecord};
use specforge::report::sidecar::Sidecar;
use specforge::report::{ReportWork, Templates};
use specforge::spec::{Claim, Value};
use specforge::study::Study;
use specforge::study::page_name::{self, Destination};

/// A folder with a store, and the reports that its plans have.
struct Project(tempfile::TempDir);

impl Project {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Works on all stages but the report of these arms, and has the command render and publish that from a
    /// saved plan.
    fn report(&self, arms: &[Arm]) -> Output {
        self.work(arms, "plan.json");
        self.command(&["report", "plan.json", "--reports", "reports"])
    }

    /// Works on all stages but the report of these arms, and saves their plan.
    fn work(&self, arms: &[Arm], saved: &str) {
        let plan = arms::plan(arms);
        let mut works: Works = StageKind::ALL
            .into_iter()
            .map(|kind| (kind, Box::new(made_up_work::MadeUp) as Box<dyn Work>))
            .collect();
        let report = ReportWork::new(Templates::default(), |_| Some("tau = a".to_string()));
        works.insert(StageKind::Report, Box::new(report));
        let (store, record, interrupt) =
            (Store::at(self.path("store")), Record::default(), Interrupt::default());
        let workshop =
            Workshop { plan: &plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
        exec::run(&workshop, &arms::options(&plan, 2)).expect("the store works");
        fs::write(self.path(saved), serde_json::to_string(&plan).expect("plain data")).expect("written");
    }

    fn command(&self, arguments: &[&str]) -> Output {
        self.prepared(arguments).output().expect("it starts")
    }

    fn prepared(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(self.0.path()).args(["--store", "store", "--color", "never"]).args(arguments);
        command
    }

    /// The pages, sorted.
    fn pages(&self) -> Vec<String> {
        let names = fs::read_dir(self.path("reports")).expect("reports").flatten();
        let names = names.filter_map(|entry| entry.file_name().into_string().ok());
        let mut pages: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
        pages.sort();
        pages
    }

    fn page(&self, name: &str) -> String {
        fs::read_to_string(self.path("reports").join(name)).expect("the page")
    }
}

/// An arm as a command asks for it.
fn asked(spec: &str, profile: Option<&str>, sets: &[&str]) -> Arm {
    let mut arm = arms::arm("atlas_run_torque", "torque");
    arm.request = Request {
        spec: spec.into(),
        place: spec.into(),
        profile: profile.map(Into::into),
        assignments: sets.iter().map(|set| (*set).to_owned()).collect(),
        outside: Vec::new(),
    };
    arm
}

/// The only line that says where the report is and why.
#[track_caller]
fn told(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    text.lines().find(|line| line.contains("so this report is")).unwrap_or_default().to_owned()
}

const SPEC: &str = "specs/atlas_run_torque.toml";

#[test]
fn another_profile_goes_to_a_page_of_its_own_and_each_is_rendered_again_in_its_place() {
    let project = Project::new();
    let with_budget = |profile, samples| {
        let mut arm = asked(SPEC, profile, &[]);
        arms::set(&mut arm, "learn.samples", Value::Count(samples), "a profile");
        arm
    };
    let (full, quick) = (with_budget(None, 2_000_000), with_budget(Some("quick"), 300_000));
    assert_eq!(told(&project.report(std::slice::from_ref(&full))), "");
    let committed = project.page("atlas_run_torque.md");
    let said = told(&project.report(std::slice::from_ref(&quick)));
    let expected =
        "reports/atlas_run_torque.md is of no profile, so this report is reports/atlas_run_torque.quick.md";
    assert_eq!(said, expected);
    assert_eq!(project.pages(), ["atlas_run_torque.md", "atlas_run_torque.quick.md"]);
    assert_eq!(project.page("atlas_run_torque.md"), committed);
    let quick_page = project.page("atlas_run_torque.quick.md");
    assert!(quick_page.contains("atlas_run_torque.quick/learning_curves.svg"), "{quick_page}");
    assert!(project.path("reports/atlas_run_torque.quick/learning_curves.svg").is_file());
    // Again: the same pages.
    assert_eq!(told(&project.report(&[full])), "");
    assert_eq!(told(&project.report(&[quick])), expected);
    assert_eq!(project.pages().len(), 2);
    // The figure and the page of a name with a dot can be traced.
    for target in [
        "reports/atlas_run_torque.quick/learning_curves.svg",
        "atlas_run_torque.quick.md#evaluation.survival",
        "reports/atlas_run_torque.quick",
    ] {
        let output = project.command(&["trace", target]);
        assert!(output.status.success(), "{target}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_first_page_of_a_profile_is_not_replaced_by_the_spec_as_it_stands() {
    let project = Project::new();
    project.report(&[asked(SPEC, Some("quick"), &[])]);
    let said = told(&project.report(&[asked(SPEC, None, &[])]));
    let expected = "reports/atlas_run_torque.md is of the profile `quick`, so this report is \
        reports/atlas_run_torque.full.md";
    assert_eq!(said, expected);
}

#[test]
fn assignments_and_other_specs_have_pages_with_a_digest_each() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    let mut set = asked(SPEC, None, &["learn.seed=2"]);
    arms::set(&mut set, "learn.seed", Value::Count(2), "--set");
    let mut other = asked("specs/other/atlas_run_torque.toml", None, &[]);
    arms::set(&mut other, "learn.seed", Value::Count(3), "specs/other/atlas_run_torque.toml:7");
    for _ in 0..2 {
        let said = told(&project.report(&[set.clone()]));
        assert!(
            said.contains("is of the spec without `--set`, so this report is reports/atlas_run_torque.full."),
            "{said}"
        );
        let said = told(&project.report(&[other.clone()]));
        assert!(said.contains("is of another spec (specs/atlas_run_torque.toml), so this"), "{said}");
        assert_eq!(project.pages().len(), 3, "{:?}", project.pages());
    }
}

#[test]
fn another_budget_of_the_same_command_has_a_page_of_its_own_and_other_edits_do_not() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    let mut edited = asked(SPEC, None, &[]);
    arms::set(
        &mut edited,
        "reward.contact_force.weight",
        arms::quantity(0.3, "0.3"),
        "specs/base/task/run.toml:40",
    );
    let before = project.page("atlas_run_torque.md");
    assert_eq!(told(&project.report(&[edited])), "");
    assert_ne!(project.page("atlas_run_torque.md"), before, "an edited spec is the same spec");
    let mut longer = asked(SPEC, None, &[]);
    arms::set(&mut longer, "learn.samples", Value::Count(2_000_001), "specs/base/task/run.toml:12");
    let said = told(&project.report(&[longer]));
    assert!(said.contains("is of another budget (2.0 M samples), so this report is"), "{said}");
}

#[test]
fn a_spec_that_was_moved_keeps_its_page_and_another_commit_is_no_reason() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    let path = project.path("reports/atlas_run_torque.json");
    let mut record: Sidecar =
        serde_json::from_str(&fs::read_to_string(&path).expect("read")).expect("a record");
    record.commit = "0123456789ab".into();
    fs::write(&path, record.to_json()).expect("written");
    assert_eq!(told(&project.report(&[asked("specs/moved.toml", None, &[])])), "");
    assert_eq!(project.pages(), ["atlas_run_torque.md"]);
}

#[test]
fn specs_of_one_name_in_several_folders_have_a_page_each() {
    for shared_place in [false, true] {
        let project = Project::new();
        let arm = |folder: &str| {
            let spec = format!("{folder}/atlas_run_torque.toml");
            fs::create_dir_all(project.path(folder)).expect("a folder");
            fs::write(project.path(&spec), "spec = 1\n").expect("it can be written");
            let mut arm = asked(&spec, None, &[]);
            if shared_place {
                // Each folder is a project of its own.
                arm.request.place = "atlas_run_torque.toml".into();
            }
            arm
        };
        let arms = ["a", "b", "c"].map(arm);
        assert_eq!(told(&project.report(&arms[..1])), "");
        let first = project.page("atlas_run_torque.md");
        for _ in 0..2 {
            for arm in &arms[1..] {
                let said = told(&project.report(std::slice::from_ref(arm)));
                let reason = match shared_place {
                    true => "is of a spec in another project, so this report",
                    false => "is of another spec (a/atlas_run_torque.toml), so this report",
                };
                assert!(said.contains(reason), "{said}");
            }
            assert_eq!(told(&project.report(&arms[..1])), "");
            assert_eq!(project.pages().len(), 3, "{:?}", project.pages());
            assert_eq!(project.page("atlas_run_torque.md"), first);
        }
    }
}

#[test]
fn specs_of_two_projects_do_not_share_a_page_in_a_folder_outside_of_both() {
    let outer = Project::new();
    let reports = outer.path("reports");
    let render = |folder: &str, value: f64| {
        let project = Project(tempfile::tempdir_in(outer.path("")).expect("a folder"));
        fs::create_dir(project.path("robots")).expect("a folder");
        // As a spec that is named by its absolute path: the record only has its place in the project.
        let mut arm = asked("atlas_run_torque.toml", None, &[]);
        arms::set(&mut arm, "reward.contact_force.weight", arms::quantity(value, &value.to_string()), folder);
        let report = || {
            project.work(std::slice::from_ref(&arm), "plan.json");
            told(&project.command(&["report", "plan.json", "--reports", reports.to_str().expect("a path")]))
        };
        [report(), report()]
    };
    assert_eq!(render("a", 0.3), ["", ""]);
    let first = outer.page("atlas_run_torque.md");
    for said in render("b", 0.4) {
        assert!(said.contains("is of a spec in another project, so this report is"), "{said}");
    }
    assert_eq!(outer.page("atlas_run_torque.md"), first);
    assert_eq!(outer.pages().len(), 2, "{:?}", outer.pages());
}

#[test]
fn a_moved_suite_keeps_its_page_unless_its_claims_are_others() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    let moved = asked("specs/moved.toml", None, &[]);
    let suite = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/studies/squatting.toml");
    let named = |claims: Vec<Claim>| {
        let mut plan = arms::plan(std::slice::from_ref(&moved));
        let suite = SuiteRecord {
            name: "s".into(),
            axes: Vec::new(),
            arms: 1,
            seeds: Vec::new(),
            claims,
            claims_count: false,
        };
        plan.suite = Some(suite);
        let (name, profiles) = ("atlas_run_torque".to_owned(), Vec::new());
        let study = Study { plan, name, project: project.path(""), profiles };
        let folder = project.path("reports");
        page_name::choice(&study, Destination { folder: &folder, own: "atlas_run_torque" }).name
    };
    assert_eq!(named(Vec::new()), "atlas_run_torque");
    let claims = specforge::check::suite(&suite, &Default::default()).claims;
    assert!(named(claims).starts_with("atlas_run_torque.full."));
}

#[test]
fn what_is_no_page_of_a_run_is_not_replaced() {
    let project = Project::new();
    fs::create_dir(project.path("reports")).expect("a folder");
    fs::write(project.path("reports/atlas_run_torque.md"), "written by hand").expect("written");
    let said = told(&project.report(&[asked(SPEC, Some("quick"), &[])]));
    assert!(
        said.contains("atlas_run_torque.md has no record that says what it is of, so this report is"),
        "{said}"
    );
    assert_eq!(project.page("atlas_run_torque.md"), "written by hand");
    fs::write(project.path("reports/atlas_run_torque.json"), "{").expect("written");
    let said = told(&project.report(&[asked(SPEC, Some("quick"), &[])]));
    assert!(said.contains("has a record that cannot be read"), "{said}");
    assert_eq!(project.page("atlas_run_torque.md"), "written by hand");
}

#[test]
fn a_comparison_of_two_specs_follows_the_same_rule() {
    let project = Project::new();
    let pair = |profile| {
        let mut other = asked("specs/atlas_run_position.toml", profile, &[]);
        other.name = "atlas_run_position".into();
        arms::set(&mut other, "name", arms::word("atlas_run_position"), "its file");
        [asked(SPEC, profile, &[]), other]
    };
    project.report(&pair(None));
    let said = told(&project.report(&pair(Some("quick"))));
    assert!(said.ends_with("so this report is reports/atlas_run_torque.quick.md"), "{said}");
    // One of the two by itself is another comparison.
    let said = told(&project.report(&[asked(SPEC, None, &[])]));
    assert!(said.contains("is of another spec"), "{said}");
}

#[test]
fn the_index_lists_a_page_beside_another_with_its_own_link() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    project.report(&[asked(SPEC, Some("quick"), &[])]);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let reports = project.path("reports");
    let output = command
        .current_dir(root)
        .args(["report", "--index", "--reports"])
        .arg(&reports)
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let index = project.page("README.md");
    for name in ["atlas_run_torque", "atlas_run_torque.quick"] {
        let row = index
            .lines()
            .find(|line| line.starts_with(&format!("| [{name}]({name}.md) |")))
            .unwrap_or_default();
        assert!(row.contains(&format!("specforge run {SPEC}")), "{name}: {index}");
    }
    // A spec called README has a page beside the index.
    fs::remove_file(reports.join("README.md")).expect("removed");
    let mut named = asked(SPEC, None, &[]);
    named.name = "README".into();
    arms::set(&mut named, "name", arms::word("README"), "its file");
    let plan = arms::plan(&[named]);
    fs::write(project.path("plan.json"), serde_json::to_string(&plan).expect("plain data")).expect("written");
    let output = project.command(&["run", "plan.json", "--reports", "reports", "--dry-run"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("README.md is the index of all reports, so this report is reports/README.full.md"),
        "{said}"
    );
}

#[test]
fn a_long_name_of_a_profile_is_cut_in_the_name_of_its_page() {
    let project = Project::new();
    project.report(&[asked(SPEC, None, &[])]);
    let profile = "p".repeat(300);
    let said = told(&project.report(&[asked(SPEC, Some(&profile), &[])]));
    assert!(said.contains(&format!("reports/atlas_run_torque.{}.", "p".repeat(60))), "{said}");
    assert_eq!(project.pages().len(), 2, "{:?}", project.pages());
}

/// The folder of reports is locked until both commands have rendered their page under the name that was free
/// when they began.
#[test]
fn runs_side_by_side_with_other_assignments_each_have_a_page() {
    let project = Project::new();
    let seeds = [1, 2].map(|seed| format!("learn.seed={seed}"));
    for (index, seed) in seeds.iter().enumerate() {
        let mut arm = asked(SPEC, None, &[seed]);
        arms::set(&mut arm, "learn.seed", Value::Count(index as u64 + 1), "--set");
        project.work(&[arm], &format!("{index}.json"));
    }
    fs::create_dir(project.path("reports")).expect("a folder");
    let lock = fs::File::open(project.path("reports")).expect("the folder");
    rustix::fs::flock(&lock, rustix::fs::FlockOperation::LockExclusive).expect("a lock");
    let commands = ["0.json", "1.json"].map(|plan| {
        let mut command = project.prepared(&["report", plan, "--reports", "reports"]);
        command.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts")
    });
    let begin = Instant::now();
    while !commands.iter().all(|child| waits_for_lock(child.id()))
        && begin.elapsed() < Duration::from_secs(30)
    {
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(lock);
    let said = commands.map(|child| told(&child.wait_with_output().expect("it ends")));
    let pages = project.pages();
    assert_eq!(pages.len(), 2, "{pages:?} {said:?}");
    assert_eq!(said.iter().filter(|line| line.is_empty()).count(), 1, "{said:?}");
    for seed in seeds {
        let held = |page: &&String| project.page(page).contains(seed.as_str());
        assert_eq!(pages.iter().filter(held).count(), 1, "{seed} {pages:?}");
    }
}

/// Whether a process waits for a file's lock.
fn waits_for_lock(process: u32) -> bool {
    let waiting = fs::read_to_string("/proc/locks").unwrap_or_default();
    waiting
        .lines()
        .any(|line| line.contains("->") && line.split_whitespace().any(|word| word == process.to_string()))
}
