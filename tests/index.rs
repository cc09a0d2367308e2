//! The page of pages says what the suites and the records of the reports say.

mod folders;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use specforge::report::claim::{Judged, Ruling};
use specforge::report::request::Request;
use specforge::report::sidecar::{Facts, RULES, Sidecar};
use specforge::report::{ReportFile, digests};

use self::folders::copy;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs `specforge report --index` over a folder of records.
fn index(reports: &Path) -> assert_cmd::assert::Assert {
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(root()).args(["report", "--index", "--reports"]).arg(reports).assert()
}

/// The folders of the repository's pages, from `reports/`.
const FOLDERS: [&str; 3] = ["", "paper", "studies"];

/// The records of the repository's reports with their pages, by the path of the page without `.md`.
fn pages() -> BTreeMap<String, PathBuf> {
    let mut pages = BTreeMap::new();
    for folder in FOLDERS {
        for entry in fs::read_dir(root().join("reports").join(folder)).expect("there are reports").flatten() {
            let path: PathBuf = entry.path();
            if path.extension().is_some_and(|ending| ending == "json") {
                let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
                pages.insert(Path::new(folder).join(name).display().to_string(), path);
            }
        }
    }
    assert!(!pages.is_empty());
    pages
}

/// Copies the records of the repository's reports with their pages, figures and policies.
fn records(folder: &Path) {
    for (page, record) in pages() {
        let path = folder.join(format!("{page}.json"));
        fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
        fs::copy(&record, &path).expect("the folder can be written");
        fs::copy(record.with_extension("md"), path.with_extension("md")).expect("it can be written");
        copy(&record.with_extension(""), &path.with_extension(""));
    }
}

/// Writes a made-up record with a page.
fn made_up(folder: &Path, record: &Sidecar) {
    let path = Sidecar::path(folder, &record.report);
    let text = format!("# {}\n", record.report);
    let page = ReportFile { path: format!("{}.md", record.report).into(), text };
    fs::write(path.with_extension("md"), &page.text).expect("it can be written");
    let record = Sidecar { digests: digests::of(&[page]), ..record.clone() };
    fs::write(path, record.sealed().to_json()).expect("it can be written");
}

#[test]
fn the_committed_page_is_what_the_suites_and_the_records_give() {
    let folder = tempfile::tempdir().expect("a folder");
    records(folder.path());
    index(folder.path()).success();
    let text = fs::read_to_string(folder.path().join("README.md")).expect("the page was written");
    let committed = root().join("reports/README.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&committed, &text).expect("the page can be written");
    }
    let committed = fs::read_to_string(committed).unwrap_or_default();
    let differ = text.lines().zip(committed.lines()).find(|(made, committed)| made != committed);
    assert_eq!(differ, None, "write it again with `specforge report --index`");
    assert_eq!(text.len(), committed.len(), "one of the two pages goes on");
}

#[test]
fn every_claim_of_every_suite_stands_on_the_page_with_its_verdict_or_as_not_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let judged = Judged {
        id: "default_gain_fails".into(),
        text: "With the default gains no run learns to walk, whatever the exploration".into(),
        metric: "deploy.mujoco.task_success".into(),
        expect: "stiffness=100 %,std=* < 50 %".into(),
        test: "wilson".into(),
        bounds: [None, Some(0.5)],
        alpha: 0.05,
        verdict: Ruling::NotEstablished,
        ..Judged::default()
    };
    let report = Sidecar {
        report: "paper_exp1".into(),
        summary: "A made-up record".into(),
        request: Request::for_spec("specs/paper/paper_exp1.toml", Some("desk")),
        facts: Facts { seeds: vec![1, 2, 3], scale: "5 %".into(), ..Facts::default() },
        claims: vec![judged],
        rules: RULES,
        ..Sidecar::default()
    };
    made_up(folder.path(), &report);
    index(folder.path()).success();
    let text = fs::read_to_string(folder.path().join("README.md")).expect("the page was written");
    let row = text
        .lines()
        .filter(|line| line.starts_with("| "))
        .find(|line| line.contains("With the default gains no run learns to walk, whatever the exploration"))
        .expect("the claim");
    assert!(row.starts_with("| [paper_exp1](paper_exp1.md) |"), "{row}");
    assert!(row.ends_with("| **NOT ESTABLISHED** | NOT ESTABLISHED | 5 % | 3 |"), "{row}");
    // The claims of the paper are those about its own setting.
    let [paper, own] =
        ["## Claims of the paper", "## Claims of our own"].map(|head| text.find(head).expect("a table"));
    let of_paper = &text[paper..own];
    assert!(of_paper.contains(row), "{text}");
    assert!(of_paper.contains("| Exp. 1: the robot cannot learn to walk with K_default |"), "{of_paper}");
    let suites = ["specs/paper", "specs/studies"]
        .map(|folder| fs::read_dir(root().join(folder)).expect("there are suites"));
    for entry in suites.into_iter().flatten().flatten().filter(|entry| entry.path().is_file()) {
        let suite = fs::read_to_string(entry.path()).expect("a suite");
        let ids = suite.lines().filter_map(|line| line.strip_prefix("text")?.split('"').nth(1));
        for text_of_claim in ids {
            assert!(text.contains(text_of_claim), "{}: {text_of_claim}", entry.path().display());
        }
    }
    assert!(text.contains("`specforge run specs/studies/walking.toml --profile desk`"), "{text}");
}

/// The row of the table of pages about a report.
fn row_of(reports: &Path, report: &str) -> String {
    index(reports).success();
    let text = fs::read_to_string(reports.join("README.md")).expect("the page was written");
    let pages = text.split("## Pages").nth(1).expect("there are reports");
    let start = format!("| [{report}]");
    pages
        .lines()
        .find(|line| line.starts_with(&start))
        .unwrap_or_else(|| panic!("{report} is not in {pages}"))
        .into()
}

/// The same record of the stages that its command would make today.
fn today(mut record: Sidecar, folder: &Path) -> Sidecar {
    let path = folder.join("plan").with_extension("txt");
    let asked = record.command();
    let words: Vec<&str> = asked.split(' ').skip(2).collect();
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(root()).arg("plan").args(words).arg("--save").arg(&path).assert().success();
    let text = fs::read_to_string(&path).expect("the plan was written");
    let plan: serde_json::Value = serde_json::from_str(&text).expect("a plan is JSON");
    let arms = plan["arms"].as_array().expect("a plan has arms");
    for (arm, planned) in record.arms.iter_mut().zip(arms) {
        assert_eq!(planned["name"], arm.name.as_str());
        for stage in &mut arm.stages {
            let key = &planned["stages"][&stage.stage];
            stage.fingerprint = key.as_str().unwrap_or(&stage.fingerprint).to_owned();
        }
    }
    // No figures lie beside the copy.
    record.items.clear();
    record
}

#[test]
fn a_report_whose_command_would_make_other_stages_today_is_marked() {
    let folder = tempfile::tempdir().expect("a folder");
    let committed = fs::read_to_string(root().join("reports/atlas_run_torque.json")).expect("the record");
    let record = today(serde_json::from_str(&committed).expect("a record"), folder.path());
    let written = |record: &Sidecar| {
        made_up(folder.path(), record);
        row_of(folder.path(), "atlas_run_torque")
    };

    let differing = |row: &str| -> usize {
        let count = row.split("| of an earlier state: ").nth(1).and_then(|rest| rest.split(' ').next());
        count.map_or(0, |count| count.parse().expect("a number"))
    };
    let before = written(&record);
    let mut other = record.clone();
    let labels =
        other.arms[0].stages.iter_mut().find(|stage| stage.stage == "pretrain").expect("it was pre-trained");
    labels.fingerprint = "0".repeat(64);
    let row = written(&other);
    assert!(!before.contains("of an earlier state") && row.contains("(pretrain)"), "{before}\n{row}");
    assert_eq!(differing(&row), 1, "{row}");

    let mut more = record.clone();
    more.request.set.push("learn.samples=1000000000".into());
    let row = written(&more);
    assert!(row.contains("learner, evaluate, export, transfer) |"), "{row}");

    let mut moved = record.clone();
    moved.request = Request::for_spec("specs/studies/gone.toml", None);
    assert!(written(&moved).ends_with("| their specs are not here |"));

    let mut foreign = record;
    foreign.request = Request::default();
    assert!(written(&foreign).ends_with("| \u{2013} |"));
}

#[test]
fn records_are_found_in_folders_of_pages_and_other_json_files_are_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    for (sub, name) in [("paper", "paper_walk"), ("studies", "walking")] {
        fs::create_dir_all(folder.path().join(sub)).expect("it can be made");
        made_up(&folder.path().join(sub), &Sidecar { report: name.into(), ..Sidecar::default() });
    }
    let runs = folder.path().join("paper/runs");
    fs::create_dir_all(&runs).expect("it can be made");
    fs::write(runs.join("paper_walk.json"), "{}").expect("it can be written");
    index(folder.path()).success();
    let text = fs::read_to_string(folder.path().join("README.md")).expect("the page was written");
    assert!(
        text.contains("| [paper_walk](paper/paper_walk.md) |")
            && text.contains("| [walking](studies/walking.md) |")
    );
    let broken = folder.path().join("studies/broken");
    fs::write(broken.with_extension("md"), "# Broken\n").expect("it can be written");
    fs::write(broken.with_extension("json"), "{}").expect("it can be written");
    let failed = index(folder.path()).code(4).get_output().clone();
    let text = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(text.contains("studies/broken.json: it is not a report's record"), "{text}");
}

#[test]
fn a_report_whose_command_fails_today_is_named_with_the_mistake() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = Sidecar {
        report: "mine".into(),
        request: Request::for_spec("specs/studies/squatting.toml", Some("nowhere")),
        ..Sidecar::default()
    };
    made_up(folder.path(), &record);
    let failed = index(folder.path()).code(3).get_output().clone();
    let text = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(text.contains(
        "the report mine was made by `specforge run specs/studies/squatting.toml --profile nowhere`"
    ));
    assert!(text.contains("E0109") || text.contains("nowhere"), "{text}");
    assert!(!folder.path().join("README.md").exists());
}

#[test]
fn a_folder_that_cannot_be_written_is_named_with_the_cure() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("file"), "not a folder").expect("it can be written");
    let failed = index(&folder.path().join("file/reports")).code(4).get_output().clone();
    let text = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(text.contains("file/reports/README.md") && text.contains("with `--reports DIR`"), "{text}");
}

#[test]
fn a_record_that_cannot_be_read_and_a_file_that_is_no_suite_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("broken.json"), "{").expect("it can be written");
    let failed = index(folder.path()).code(4).get_output().clone();
    let text = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(text.contains("broken.json: it is not a report's record"), "{text}");
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    let command = command.current_dir(root()).args(["report", "--index", "specs/atlas_run_torque.toml"]);
    let failed = command.assert().code(2).get_output().clone();
    let text = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(text.contains("specs/atlas_run_torque.toml is not a suite"), "{text}");
}

#[test]
fn the_committed_pages_are_as_they_were_rendered() {
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(root()).args(["report", "--check"]).assert().success();
}
