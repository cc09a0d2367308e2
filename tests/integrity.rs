//! A report is verified by the digests of its record: every edit, loss or exchange of its files is named with
//! the cure.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use specforge::report::earlier::NOTICE;
use specforge::report::sidecar::{Item, RULES, Sidecar};
use specforge::report::{ReportFile, digests};
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

/// The record with claims and the values of their runs that the rules give (tests/verdicts.rs), under a name.
fn record(name: &str) -> Sidecar {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/verdicts/made_up.json");
    let figure = Item {
        id: "speed".into(),
        kind: "figure".into(),
        file: format!("{name}/speed.svg"),
        ..Item::default()
    };
    let command = format!("specforge run specs/{name}.toml --profile desk");
    Sidecar { report: name.into(), command, items: vec![figure], ..Sidecar::read(&path).expect("the record") }
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
    assert!(!told(&output).contains("cannot be verified"), "{}", told(&output));
    // Another layout of the same content is no change, and a file of somebody else is none of ours.
    let path = folder.path().join("studies/walk.json");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("a record")).expect("JSON");
    fs::write(&path, json.to_string()).expect("it can be written");
    fs::write(folder.path().join("studies/notes.md"), "# Notes\n").expect("it can be written");
    let output = report(folder.path(), &["--check", "--format", "json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(answer, serde_json::json!({ "whole": 2, "differing": [], "unverifiable": [] }));
    let output = report(folder.path(), &["--index", SUITE]);
    assert!(output.status.success(), "{}", told(&output));
    let index = fs::read_to_string(folder.path().join("README.md")).expect("an index");
    assert!(index.contains("[walk](studies/walk.md)") && !index.contains("Not verifiable"), "{index}");
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
        ("the command", "--profile desk", "--profile paper"),
        ("the digest of the page", "\"walk.md\": \"", "\"walk.txt\": \""),
    ] {
        let folder = published();
        edited(&folder.path().join("studies/walk.json"), from, to);
        let notice = ("studies/walk.md", "it does not say that it was judged by earlier rules");
        let output = report(folder.path(), &["--check"]);
        // A record that says that it is of earlier rules wants the notice on its page, too.
        if case == "the rules" {
            assert!(told(&output).contains(notice.1), "{}", told(&output));
            let index = report(folder.path(), &["--index", SUITE]);
            assert!(index.status.code() == Some(4) && told(&index).contains(CHANGED), "{}", told(&index));
            continue;
        }
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

    // The digest that was taken out says nothing any more, which is told.
    let unsealed = published();
    let record = Sidecar::read(&below(&unsealed, "walk.json")).expect("a record");
    fs::write(below(&unsealed, "walk.json"), Sidecar { seal: String::new(), ..record }.to_json())
        .expect("written");
    let output = report(unsealed.path(), &["--check"]);
    let text = told(&output);
    assert!(output.status.success() && text.contains("unchanged since they were rendered: 1;"), "{text}");
    assert!(
        text.contains("cannot be verified, because the record has no digest of itself: studies/walk (1)"),
        "{text}"
    );
}

#[test]
fn pages_and_figures_that_were_edited_or_are_gone_are_found() {
    let changed = "it was changed after it was rendered";
    let folder = published();
    edited(&folder.path().join("studies/walk.md"), "It walks", "It runs");
    edited(&folder.path().join("studies/run/speed.svg"), "speed", "height");
    finds(folder.path(), "edited", &[("studies/walk.md", changed), ("studies/run/speed.svg", changed)]);
    let folder = published();
    edited(&folder.path().join("studies/walk.md"), "\nIt walks", &format!("\n{NOTICE}\n\nIt walks"));
    let reason = "it says that it was judged by earlier rules, and its record does not";
    finds(folder.path(), "a false notice", &[("studies/walk.md", reason)]);
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
fn records_of_earlier_versions_are_accepted_and_counted_but_their_files_must_be_there() {
    let folder = tempfile::tempdir().expect("a folder");
    publish(folder.path(), "walk");
    let old = Sidecar { rules: 0, ..record("walk") };
    fs::write(folder.path().join("walk.json"), old.to_json()).expect("it can be written");
    let page = folder.path().join("walk.md");
    let output = report(folder.path(), &["--check"]);
    let reason = "it does not say that it was judged by earlier rules";
    assert!(output.status.code() == Some(4) && told(&output).contains(reason), "{}", told(&output));
    let output = report(folder.path(), &["--index", SUITE]);
    let open =
        "cannot be verified, because the record has no digests of itself, the page and the figures: walk (1)";
    assert!(output.status.success() && told(&output).contains(open), "{}", told(&output));
    let index = fs::read_to_string(folder.path().join("README.md")).expect("an index");
    assert!(index.contains("## Not verifiable") && index.contains("[walk](walk.md).\n"), "{index}");
    let output = report(folder.path(), &["--check"]);
    assert!(output.status.success() && told(&output).contains(open), "{}", told(&output));
    // An edited notice is one that is missing.
    edited(&page, "cannot be computed again", "can be computed again");
    let output = report(folder.path(), &["--check"]);
    assert!(output.status.code() == Some(4) && told(&output).contains(reason), "{}", told(&output));
    fs::remove_file(folder.path().join("README.md")).expect("it is there");
    fs::remove_file(&page).expect("it is there");
    fs::remove_file(folder.path().join("walk/speed.svg")).expect("it is there");
    let missing = ["walk.md", "walk/speed.svg"].map(|file| (file, "it is missing, and its record is there"));
    finds(folder.path(), "an earlier record alone", &missing);
}
