//! A report is verified by the digests of its record: every edit, loss or exchange of its files is named with
//! the cure.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use specforge::plan::StageKind;
use specforge::report::claim::{Judged, Ruling, again, expectation, measured};
use specforge::report::model::StageRecord;
use specforge::report::request::Request;
use specforge::report::sidecar::{ArmRecord, Facts, Item, RULES, Sidecar};
use specforge::report::{ReportFile, digests, listing};
use specforge::seal::{self, REMOVED};
use specforge::spec::{Claim, Value};
use specforge::study::{Log, Study, out_of_date};
use tempfile::TempDir;

/// The suite that an index is asked for.
const SUITE: &str = "specs/studies/squatting.toml";

/// Runs `specforge report` in the repository over a folder of reports.
fn report(reports: &Path, words: &[&str]) -> Output {
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("report").args(words).arg("--reports").arg(reports);
    command.output().expect("it runs")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Claims of the made-up record whose tests take no draws.
const CLAIMS: [&str; 6] = ["welch", "welch_of_one", "each_ground", "ratio", "wilson", "falls"];

/// The record with claims and the values of their runs that the rules give (tests/verdicts.rs), under a name.
fn record(name: &str) -> Sidecar {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/verdicts/made_up.json");
    let figure = Item {
        id: "speed".into(),
        kind: "figure".into(),
        file: format!("{name}/speed.svg"),
        ..Item::default()
    };
    let request = Request::for_spec(&format!("specs/{name}.toml"), Some("desk"));
    let mut record = Sidecar::read(&path).expect("the record");
    record.claims.retain(|claim| CLAIMS.contains(&claim.id.as_str()));
    let claims = again(&record.claims).expect("it has all values");
    Sidecar { report: name.into(), request, items: vec![figure], claims, ..record }
}

/// Publishes a page with a figure and its sealed record.
fn publish(folder: &Path, name: &str) {
    let file = |path: String, text: String| ReportFile { path: path.into(), text };
    let page = file(format!("{name}.md"), format!("# {name}\n\nIt walks. Rendered by specforge 0.1.0.\n"));
    let metadata = format!("<metadata>{{\"report\":\"{name}\",\"figure\":\"speed\"}}</metadata>");
    let figure = file(format!("{name}/speed.svg"), format!("<svg>{metadata}</svg>\n"));
    let files = [page, figure];
    let record = Sidecar { digests: digests::of(&files), ..record(name) }.sealed();
    fs::create_dir_all(folder.join(name)).expect("it can be made");
    for ReportFile { path, text } in &files {
        fs::write(folder.join(path), text).expect("it can be written");
    }
    fs::write(Sidecar::path(folder, name), record.to_json()).expect("it can be written");
}

/// Two reports in a folder of their own below the folder of reports.
fn published() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let below = folder.path().join("studies");
    ["walk", "run"].iter().for_each(|name| publish(&below, name));
    folder
}

/// Asserts that `--check` and `--index` name exactly these files as not as they were, and that there is no
/// index.
fn finds(folder: &Path, case: &str, expected: &[(&str, &str)]) {
    for words in [&["--check"][..], &["--index", SUITE]] {
        let output = report(folder, words);
        let text = told(&output);
        assert_eq!(output.status.code(), Some(4), "{case} {words:?}: {text}");
        assert_eq!(text.matches("[R0013]").count(), expected.len(), "{case} {words:?}: {text}");
        for (file, reason) in expected {
            let line = format!("[R0013] {}: {reason}", folder.join(file).display());
            assert!(text.contains(&line), "{case} {words:?}: `{line}` is not in {text}");
        }
        assert!(text.contains("from version control") && text.contains("specforge report"), "{case}: {text}");
        assert!(!folder.join("README.md").exists(), "{case}: the index believes it");
    }
}

fn edited(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).expect("it is there");
    let changed = text.replacen(from, to, 1);
    assert_ne!(changed, text, "`{from}` is in {}", path.display());
    fs::write(path, changed).expect("it can be written");
}

const CHANGED: &str = "it was changed after it was written: it does not have its own digest";

#[test]
fn reports_that_nobody_touched_are_whole_and_have_an_index() {
    let folder = published();
    let output = report(folder.path(), &["--check"]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(
        told(&output).contains("reports unchanged since they were rendered: 2; changed: 0"),
        "{}",
        told(&output)
    );
    // Another layout of the same content is no change, and a file of somebody else is none of ours.
    let path = folder.path().join("studies/walk.json");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("a record")).expect("JSON");
    fs::write(&path, json.to_string()).expect("it can be written");
    fs::write(folder.path().join("studies/notes.md"), "# Notes\n").expect("it can be written");
    let output = report(folder.path(), &["--check", "--format", "json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    // Their specs are made up.
    let older = answer["out_of_date"].as_array().expect("a list").iter().map(|older| older["reason"].clone());
    let expected = ["run", "walk"].map(|name| format!("its spec specs/{name}.toml does not exist"));
    assert_eq!(older.collect::<Vec<_>>(), expected);
    let differing = serde_json::json!([]);
    assert_eq!((&answer["whole"], &answer["differing"]), (&serde_json::json!(2), &differing));
    assert_eq!(answer["runs"], 0);
    let output = report(folder.path(), &["--index", SUITE]);
    assert!(output.status.success(), "{}", told(&output));
    let index = fs::read_to_string(folder.path().join("README.md")).expect("an index");
    assert!(index.contains("[walk](studies/walk.md)"), "{index}");
}

#[test]
fn every_edit_of_a_record_is_found() {
    let record = fs::read_to_string(published().path().join("studies/walk.json")).expect("a record");
    let p = record.lines().find(|line| line.contains("\"p\": 0.")).expect("a p value").trim().to_owned();
    let adjusted =
        record.lines().find(|line| line.contains("\"p_adjusted\": 0.")).expect("a p value").trim().to_owned();
    let value = record
        .lines()
        .map(str::trim)
        .find(|line| line.starts_with("0."))
        .expect("a value of a run")
        .to_owned();
    for (case, from, to) in [
        ("a verdict", "\"verdict\": \"FAIL\"", "\"verdict\": \"PASS\""),
        ("a p value", p.as_str(), "\"p\": 0.0001,"),
        ("a corrected p value", adjusted.as_str(), "\"p_adjusted\": 0.0001,"),
        ("the value of a run", value.as_str(), "0.123456,"),
        ("the rules", &format!("\"rules\": {RULES}"), "\"rules\": 1"),
        ("the profile", "\"profile\": \"desk\"", "\"profile\": \"paper\""),
        ("the digest of the page", "\"walk.md\": \"", "\"walk.txt\": \""),
    ] {
        let folder = published();
        edited(&folder.path().join("studies/walk.json"), from, to);
        let lost = ("studies/walk.txt", "it is missing");
        let more = if case == "the digest of the page" { Some(lost) } else { None };
        let expected: Vec<_> = more.into_iter().chain([("studies/walk.json", CHANGED)]).collect();
        finds(folder.path(), case, &expected);
    }
}

#[test]
fn a_record_that_was_cut_or_is_gone_or_belongs_to_another_page_is_found() {
    let below = |folder: &TempDir, file: &str| -> PathBuf { folder.path().join("studies").join(file) };
    let cut = published();
    let text = fs::read_to_string(below(&cut, "walk.json")).expect("a record");
    fs::write(below(&cut, "walk.json"), &text[..text.len() / 2]).expect("it can be written");
    finds(cut.path(), "a cut record", &[("studies/walk.json", "it is not a report's record")]);

    let gone = published();
    fs::remove_file(below(&gone, "walk.json")).expect("it is there");
    let reason = "it is the page of a report, and its record is missing";
    finds(gone.path(), "a page without record", &[("studies/walk.md", reason)]);
    // Of a template that says nothing of its origin the figures tell it.
    fs::write(below(&gone, "walk.md"), "# My own template\n").expect("it can be written");
    finds(gone.path(), "a page of another template", &[("studies/walk.md", reason)]);
    fs::remove_file(below(&gone, "walk.md")).expect("it is there");
    let reason = "it is the figure of a report, and page and record are missing";
    finds(gone.path(), "a figure alone", &[("studies/walk/speed.svg", reason)]);

    let swapped = published();
    fs::rename(below(&swapped, "walk.json"), below(&swapped, "walk")).expect_err("a folder is there");
    fs::rename(below(&swapped, "walk.json"), below(&swapped, "kept")).expect("it can be moved");
    fs::rename(below(&swapped, "run.json"), below(&swapped, "walk.json")).expect("it can be moved");
    fs::rename(below(&swapped, "kept"), below(&swapped, "run.json")).expect("it can be moved");
    let expected = [
        ("studies/walk.json", "it is the record of another page, `run`"),
        ("studies/run.json", "it is the record of another page, `walk`"),
    ];
    finds(swapped.path(), "exchanged records", &expected);

    // A digest that was taken out is one that is missing, whatever else was taken out with it.
    for strip in [
        |record: Sidecar| Sidecar { seal: String::new(), ..record },
        |record: Sidecar| Sidecar { seal: String::new(), digests: Default::default(), ..record },
        |record: Sidecar| Sidecar {
            seal: String::new(),
            digests: Default::default(),
            rules: 0,
            runs: Vec::new(),
            ..record
        },
    ] {
        let unsealed = published();
        let record = strip(Sidecar::read(&below(&unsealed, "walk.json")).expect("a record"));
        fs::write(below(&unsealed, "walk.json"), record.to_json()).expect("written");
        let output = report(unsealed.path(), &["--check"]);
        let text = told(&output);
        assert!(
            output.status.code() == Some(4) && text.contains(&format!("studies/walk.json: {REMOVED}")),
            "{text}"
        );
        assert!(text.contains("unchanged since they were rendered: 1; changed: 1"), "{text}");
        assert_eq!(report(unsealed.path(), &["--index", SUITE]).status.code(), Some(4), "{text}");
        let traced = trace(&below(&unsealed, "walk.md"));
        assert!(traced.status.code() == Some(4) && told(&traced).contains(REMOVED), "{}", told(&traced));
    }
}

/// Runs `specforge trace`.
fn trace(target: &Path) -> Output {
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.arg("trace").arg(target).output().expect("it runs")
}

/// Changes the record of a page and gives it the digest of what it says now.
fn resealed(folder: &Path, name: &str, change: impl FnOnce(&mut Sidecar)) {
    let path = Sidecar::path(folder, name);
    let mut record = Sidecar::read(&path).expect("a record");
    change(&mut record);
    fs::write(path, record.sealed().to_json()).expect("it can be written");
}

#[test]
fn a_verdict_that_its_values_do_not_give_is_found_whoever_sealed_it() {
    let of = |record: &mut Sidecar, id: &str| -> usize {
        record.claims.iter().position(|claim| claim.id == id).unwrap_or_else(|| panic!("{id} is a claim"))
    };
    type Change = (&'static str, fn(&mut Sidecar, usize), &'static str, &'static str);
    let changes: [Change; 7] = [
        (
            "welch_of_one",
            |record, at| record.claims[at].verdict = Ruling::Pass,
            "a verdict",
            "is PASS, and its values give FAIL",
        ),
        (
            "welch",
            |record, at| record.claims[at].p = Some(0.04),
            "a p value",
            "has another `p` than its values give",
        ),
        (
            "welch",
            |record, at| record.claims[at].cases[0].estimate.value = Some(0.9),
            "an estimate",
            "has another `cases.0.estimate.value` than its values give",
        ),
        (
            "welch",
            |record, at| record.claims[at].bounds = [Some(0.7), None],
            "a boundary",
            "is PASS, and its values give",
        ),
        (
            "welch",
            |record, _| record.runs.iter_mut().for_each(|run| run.stages.clear()),
            "the table of runs",
            "has another value of",
        ),
        (
            "wilson",
            |record, at| record.claims[at].cases[0].evidence = None,
            "no values",
            "has a comparison without values",
        ),
        (
            "ratio",
            |record, at| record.claims[at].failing.clear(),
            "what fails",
            "is NOT MEANINGFUL, and its values give",
        ),
    ];
    for (id, change, case, reason) in changes {
        let folder = published();
        resealed(&folder.path().join("studies"), "walk", |record| {
            let at = of(record, id);
            change(record, at);
        });
        let output = report(folder.path(), &["--check"]);
        let expected = format!("studies/walk.json: its claim `{id}` {reason}");
        assert!(
            output.status.code() == Some(4) && told(&output).contains(&expected),
            "{case}: {}",
            told(&output)
        );
        assert_eq!(report(folder.path(), &["--index", SUITE]).status.code(), Some(4), "{case}");
    }
}

/// Verdicts by other rules cannot be compared with their values: the page is out of date, not edited.
#[test]
fn a_page_that_was_judged_by_other_rules_is_out_of_date() {
    for rules in [RULES - 1, RULES + 1] {
        let folder = published();
        resealed(&folder.path().join("studies"), "walk", |record| {
            record.rules = rules;
            record.claims[0].p = Some(0.04);
        });
        let output = report(folder.path(), &["--check"]);
        let text = told(&output);
        assert_eq!(output.status.code(), Some(4), "{text}");
        let reason = format!("studies/walk.json: its claims were judged by version {rules} of the rules");
        let again = "render it again: `specforge report specs/walk.toml --profile desk --reports";
        assert!(text.contains(&reason) && text.contains(again) && !text.contains("[R0013]"), "{text}");
        let output = report(folder.path(), &["--index", SUITE]);
        assert!(output.status.success(), "{}", told(&output));
    }
}

#[test]
fn an_index_that_was_edited_or_is_older_than_a_record_is_found_and_written_again() {
    let folder = published();
    let index = folder.path().join("README.md");
    let check = || report(folder.path(), &["--check"]);
    let write = || assert!(report(folder.path(), &["--index", SUITE]).status.success());
    let again = format!("`specforge report --index --reports {}` writes it again", folder.path().display());
    write();
    assert!(check().status.success(), "{}", told(&check()));
    edited(&index, "walk", "work");
    let text = told(&check());
    assert!(
        check().status.code() == Some(4) && text.contains("README.md: it was changed after it was written"),
        "{text}"
    );
    assert!(text.contains(&again), "{text}");
    write();
    let whole = fs::read_to_string(&index).expect("an index");
    let without = whole.trim_end().rsplit_once('\n').expect("it has lines").0;
    fs::write(&index, without).expect("it can be written");
    assert!(told(&check()).contains("its last line with its digest is missing"), "{}", told(&check()));
    write();
    publish(&folder.path().join("studies"), "stand");
    let text = told(&check());
    assert!(text.contains("it is out of date: it was written from other records"), "{text}");
    assert!(text.contains("changed: 0; out of date: 4") && !text.contains("R0013"), "{text}");
    assert!(text.contains(&again), "{text}");
    assert_eq!(check().status.code(), Some(4), "{text}");
    write();
    assert!(check().status.success(), "{}", told(&check()));
    // A page of somebody else is no index.
    fs::write(&index, "# My reports\n").expect("it can be written");
    assert!(check().status.success(), "{}", told(&check()));
}

/// The record of a page that its command would render today, in which all runs have their results.
fn current(request: Request) -> Sidecar {
    let (files, options) = (request.paths(), request.options());
    let study = Study::read(&files, &options, &mut Log::default()).expect("a valid suite");
    let suite = study.plan.suite.clone().expect("a suite");
    let judged = |claim: &Claim| Judged {
        id: claim.id.clone(),
        text: claim.text.clone(),
        metric: measured(claim),
        expect: expectation(claim),
        ..Judged::default()
    };
    let stage = |(stage, key): (&String, &specforge::plan::Fingerprint)| StageRecord {
        stage: stage.clone(),
        fingerprint: key.to_string(),
        ..StageRecord::default()
    };
    let arms = study.plan.arms.iter().map(|arm| ArmRecord {
        name: arm.name.clone(),
        stages: arm.stages.iter().map(stage).collect(),
        ..ArmRecord::default()
    });
    let runs = study.plan.arms.len();
    let facts = Facts { seeds: suite.seeds, runs, complete: runs, ..Facts::default() };
    let report = study.plan.stages().find(|stage| stage.kind == StageKind::Report).expect("a report");
    let summary = match &report.fields["summary"] {
        Value::Text(text) => text.clone(),
        other => panic!("the summary is not a text: {other:?}"),
    };
    let claims = suite.claims.iter().map(judged).collect();
    Sidecar { request, summary, facts, claims, arms: arms.collect(), ..Sidecar::default() }
}

#[test]
fn a_page_whose_claims_changed_in_its_suite_is_out_of_date() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = current(Request::for_spec(SUITE, None));
    let found = |record: &Sidecar| out_of_date::find(record, Path::new("reports/studies"));
    assert_eq!(found(&record), None);
    let mut other = record.clone();
    other.claims[0].text = "Another sentence".into();
    let id = &record.claims[0].id;
    let reason = found(&other).expect("it is out of date").reason;
    assert!(reason.contains(&format!("the claim `{id}` changed in {SUITE}")), "{reason}");
    let mut more = record.clone();
    more.claims.push(Judged { id: "gone".into(), ..Default::default() });
    assert!(found(&more).expect("it is out of date").reason.contains("`gone`"));
    // The command says so, and the page is unchanged nevertheless.
    publish(folder.path(), "walk");
    resealed(folder.path(), "walk", |walk| walk.request = other.request.clone());
    let output = report(folder.path(), &["--check"]);
    assert!(output.status.success(), "{}", told(&output));
    let text = told(&output);
    assert!(text.contains("walk.md: it is out of date: the claims") && text.contains(SUITE), "{text}");
}

#[test]
fn a_page_is_out_of_date_after_any_change_of_its_suite_or_its_parents_and_without_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let command = |words: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        command.current_dir(folder.path()).args(words).assert().success();
    };
    command(&["new", "walk.toml", "--standalone", "--task", "walk", "--robot", "tocabi"]);
    command(&["new", "s.toml", "--suite", "walk.toml"]);
    let record = current(Request::for_spec(&file("s.toml").display().to_string(), Some("quick")));
    let found = || out_of_date::find(&record, &file("reports"));
    assert_eq!(found(), None);
    let changes = |name: &str, from: &str, to: &str, reason: &str| {
        let text = fs::read_to_string(file(name)).expect("it is there");
        edited(&file(name), from, to);
        let told = found().unwrap_or_else(|| panic!("`{to}` is not seen"));
        assert!(told.reason.contains(reason), "{to}: {}", told.reason);
        let again = format!("specforge report {} --profile quick --reports", file("s.toml").display());
        assert!(told.fix.contains(&again) || told.fix.contains("specforge check"), "{}", told.fix);
        assert!(told.fix.contains("--profile quick"), "{}", told.fix);
        fs::write(file(name), text).expect("it can be written");
        assert_eq!(found(), None);
    };
    changes("s.toml", "What the weight", "How the weight", "its summary changed");
    changes("s.toml", "seeds = 3", "seeds = [1, 2, 3, 7]", "the seeds are");
    changes("s.toml", "values = [0.05, 0.2]", "values = [0.05, 0.2, 0.3]", "stages differ");
    changes("walk.toml", "speed = \"0.2 m/s\"", "speed = \"0.3 m/s\"", "stages differ (evaluate");
    changes("walk.toml", "episodes = 32", "episodes = 33", "stages differ (evaluate, transfer)");
    changes("s.toml", "a > 50 %", "a > 60 %", "the claim `heavier_survives` changed");
    changes("walk.toml", "[evaluate.nominal]", "[evaluate.nominal", "its specs have errors now");
    for name in ["walk.toml", "s.toml"] {
        let text = fs::read_to_string(file(name)).expect("it is there");
        fs::remove_file(file(name)).expect("it is there");
        let told = found().expect("it is seen");
        let expected = if name == "s.toml" { "s.toml does not exist" } else { "its specs have errors now" };
        assert!(told.reason.contains(expected), "{}", told.reason);
        fs::write(file(name), text).expect("it can be written");
    }
}

#[test]
fn the_advice_names_the_options_of_the_run_and_the_folder_of_the_page() {
    let folder = published();
    let below = folder.path().join("studies");
    let again = |name: &str| {
        format!("`specforge report specs/{name}.toml --profile desk --reports {}`", below.display())
    };
    let advises = |case: &str, advice: &str| {
        let text = told(&report(folder.path(), &["--check"]));
        let helps: Vec<&str> = text.lines().filter(|line| line.starts_with("help: ")).collect();
        assert!(helps.iter().any(|line| line.contains(advice)), "{case}: `{advice}` is not in {text}");
    };
    edited(&below.join("walk.md"), "It walks", "It runs");
    advises("an edited page", &again("walk"));
    fs::write(below.join("run/more.svg"), "<svg/>").expect("it can be written");
    advises("a figure that no record lists", &again("run"));
    resealed(&below, "run", |run| run.report = "other".into());
    advises("a record of another page", &again("run"));
    // The options in an edited record are not repeated as advice.
    edited(&below.join("run.json"), "\"profile\": \"desk\"", "\"profile\": \"quick\"");
    advises("an edited record", "`specforge report SPEC` with the `--profile` and `--set` of its run");
}

#[test]
fn figures_that_no_record_lists_and_copies_of_reports_are_found() {
    let stray = "it is not a figure of any report here: no record lists it";
    let folder = published();
    let at = |file: &str| folder.path().join("studies").join(file);
    fs::copy(at("walk/speed.svg"), at("walk/faster.svg")).expect("it can be copied");
    fs::write(at("run/photo.png"), b"not listed").expect("it can be written");
    fs::write(at("plot.svg"), "<svg/>").expect("it can be written");
    let found =
        [("studies/plot.svg", stray), ("studies/run/photo.png", stray), ("studies/walk/faster.svg", stray)];
    finds(folder.path(), "added figures", &found);

    // A copy of all files of a report in another folder.
    let folder = published();
    let copy = folder.path().join("paper");
    fs::create_dir_all(copy.join("walk")).expect("it can be made");
    for file in ["walk.md", "walk.json", "walk/speed.svg"] {
        fs::copy(folder.path().join("studies").join(file), copy.join(file)).expect("it can be copied");
    }
    let same =
        |other: &str| format!("it is the same record as that of `{other}`: one of the reports is a copy");
    let (one, other) = (same("studies/walk"), same("paper/walk"));
    finds(folder.path(), "a copy", &[("paper/walk.json", &one), ("studies/walk.json", &other)]);
    // Of a report whose spec says where it belongs the copy is the other one.
    let at_home = |record: &mut Sidecar| record.request.specs = vec!["specs/studies/walk.toml".into()];
    [folder.path().join("studies"), copy.clone()].iter().for_each(|folder| resealed(folder, "walk", at_home));
    finds(folder.path(), "a copy", &[("paper/walk.json", &one)]);
    ["walk.md", "walk.json", "walk/speed.svg"]
        .iter()
        .for_each(|file| fs::remove_file(folder.path().join("studies").join(file)).expect("it is there"));
    let moved = "it is the record of a page in `studies/`, where its spec has it";
    finds(folder.path(), "a report that was moved", &[("paper/walk.json", moved)]);

    // The record alone, in a folder without pages.
    let folder = published();
    let runs = folder.path().join("studies/runs");
    fs::create_dir_all(&runs).expect("it can be made");
    fs::copy(folder.path().join("studies/walk.json"), runs.join("mine.json")).expect("it can be copied");
    let text = told(&report(folder.path(), &["--check"]));
    assert!(text.contains("studies/runs/mine.json: it is the record of another page, `walk`"), "{text}");
}

#[test]
fn trace_does_not_answer_for_a_page_or_a_figure_that_does_not_match_its_record() {
    let folder = published();
    let at = |file: &str| folder.path().join("studies").join(file);
    assert!(trace(&at("walk/speed.svg")).status.success(), "{}", told(&trace(&at("walk/speed.svg"))));
    assert!(trace(&at("walk.md")).status.success(), "{}", told(&trace(&at("walk.md"))));
    let refuses = |target: &str, reason: &str| {
        let output = trace(&at(target));
        let text = told(&output);
        assert!(output.status.code() == Some(4) && output.stdout.is_empty(), "{target}: {text}");
        assert!(text.contains("[R0013]") && text.contains(reason), "{target}: {text}");
    };
    edited(&at("walk.md"), "It walks", "It runs");
    refuses("walk.md", "walk.md: it does not match its record: it was changed after it was rendered");
    refuses("walk.json", "walk.md: it does not match its record");
    edited(&at("walk/speed.svg"), "<svg>", "<svg><path/>");
    refuses("walk/speed.svg", "walk/speed.svg: it does not match its record: it was changed");
    fs::remove_file(at("run/speed.svg")).expect("it is there");
    refuses("run/speed.svg", "run/speed.svg: it does not match its record: it is missing");
    fs::copy(at("run.json"), at("stand.json")).expect("it can be copied");
    refuses("stand.json", "`stand.json` is the record of another page, `run`");
}

#[test]
fn pages_and_figures_that_were_edited_or_are_gone_are_found() {
    let changed = "it was changed after it was rendered";
    let folder = published();
    edited(&folder.path().join("studies/walk.md"), "It walks", "It runs");
    edited(&folder.path().join("studies/run/speed.svg"), "speed", "height");
    finds(folder.path(), "edited", &[("studies/walk.md", changed), ("studies/run/speed.svg", changed)]);
    let folder = published();
    fs::remove_file(folder.path().join("studies/walk.md")).expect("it is there");
    fs::remove_file(folder.path().join("studies/run/speed.svg")).expect("it is there");
    finds(
        folder.path(),
        "gone",
        &[("studies/walk.md", "it is missing"), ("studies/run/speed.svg", "it is missing")],
    );
    // The last pages of a folder are missed as well.
    fs::remove_file(folder.path().join("studies/run.md")).expect("it is there");
    let missing =
        ["studies/walk.md", "studies/run.md", "studies/run/speed.svg"].map(|file| (file, "it is missing"));
    finds(folder.path(), "all pages gone", &missing);
}

#[test]
fn records_of_runs_are_verified_as_those_of_reports() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/paper/runs");
    let Some(path) = listing::files(&source, "json").into_iter().next() else { return };
    let whole = fs::read_to_string(&path).expect("a record");
    let folder = tempfile::tempdir().expect("a folder");
    let runs = folder.path().join("runs");
    fs::create_dir(&runs).expect("it can be made");
    let name = path.file_name().expect("a name").to_string_lossy().into_owned();
    let record = runs.join(&name);
    let check = |text: &str| {
        fs::write(&record, text).expect("it can be written");
        let output = report(folder.path(), &["--check"]);
        (output.status.code(), told(&output))
    };
    let (code, text) = check(&whole);
    assert!(code == Some(0) && text.contains("records of runs that are as they were written: 1"), "{text}");
    let json: serde_json::Value = serde_json::from_str(&whole).expect("JSON");
    let run = json["run"].as_str().expect("a name").to_owned();
    let changed = check(&whole.replacen(&run, "another run", 1));
    assert!(
        changed.0 == Some(4) && changed.1.contains(&format!("{name}: it was changed after it was written")),
        "{}",
        changed.1
    );
    let stripped = |format: u32| {
        let mut stripped = json.clone();
        stripped.as_object_mut().expect("an object").shift_remove(seal::FIELD);
        stripped["format"] = format.into();
        stripped.to_string()
    };
    for (format, reason) in [(2, "its format is 2, this version reads 3"), (3, REMOVED)] {
        let (code, text) = check(&stripped(format));
        assert!(code == Some(4) && text.contains(&format!("{name}: {reason}")), "{text}");
        let mut import = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        let store = folder.path().join("store");
        let import = import.arg("--store").arg(store).args(["cache", "import"]).arg(&runs).assert().code(4);
        let text = told(import.get_output());
        assert!(text.contains(reason), "{text}");
    }
    let (code, text) = check(&whole[..whole.len() / 2]);
    assert!(code == Some(4) && text.contains(&format!("runs/{name}: it is not JSON")), "{text}");
}

#[test]
fn a_record_of_a_run_under_another_name_and_a_copy_elsewhere_are_found() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/paper/runs");
    let paths = listing::files(&source, "json");
    let [path, other, ..] = &paths[..] else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let runs = folder.path().join("runs");
    fs::create_dir(&runs).expect("it can be made");
    let name = |path: &Path| path.file_name().expect("a name").to_string_lossy().into_owned();
    let import = || {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        let store = folder.path().join("store");
        let output = command.arg("--store").arg(store).args(["cache", "import"]).arg(&runs).output();
        let output = output.expect("it runs");
        (output.status.code(), told(&output))
    };
    let check = || {
        let output = report(folder.path(), &["--check"]);
        (output.status.code(), told(&output))
    };
    for wrong in [name(other), "copy.json".to_owned(), name(path).replace(".json", " (1).json")] {
        fs::copy(path, runs.join(&wrong)).expect("it can be copied");
        for (code, text) in [check(), import()] {
            assert!(code == Some(4) && text.contains("it was renamed or copied"), "{wrong}: {text}");
            assert!(text.contains(&wrong), "{text}");
        }
        fs::remove_file(runs.join(&wrong)).expect("it is there");
    }
    fs::copy(path, runs.join(name(path))).expect("it can be copied");
    assert_eq!(check().0, Some(0), "{}", check().1);
    let more = folder.path().join("more/runs");
    fs::create_dir_all(&more).expect("it can be made");
    fs::copy(path, more.join(name(path))).expect("it can be copied");
    let (code, text) = check();
    assert!(code == Some(4) && text.contains("it is the same record of a run as"), "{text}");
}
