//! One cause gives one error: every mistake of a table, each in the spec, in a parent, in a profile and on
//! the command line, gives exactly one error with the expected code, in the text where it was made.

#[path = "mistakes/table.rs"]
mod table;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use specforge::check::{Checked, checked_in};
use specforge::diag::Severity;
use specforge::diag::render::{Look, github, human, json};
use specforge::spec::LoadOptions;
use specforge::syntax::{Nowhere, Overlay};

use table::{MISTAKES, Mistake, TEXTS};

const HEAD: &str = "spec = 1\nname = \"a\"\n";

fn whole() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
    fs::read_to_string(path).expect("whole.toml is readable")
}

/// Checks `spec.toml` of these files, which lie in memory beside `whole.toml`.
fn check(files: &[(&str, &str)], options: &LoadOptions) -> Checked {
    let mut overlay = Overlay::new(Nowhere);
    overlay.hold(Path::new("whole.toml"), whole());
    files.iter().for_each(|(name, text)| overlay.hold(Path::new(name), *text));
    checked_in(&overlay, Path::new("spec.toml"), options)
}

/// What is wrong with what was found, when one error with this code in this text was expected.
fn verdict(checked: &Checked, code: &str, place: &str) -> Option<String> {
    let errors: Vec<_> =
        checked.sink.diagnostics.iter().filter(|found| found.severity == Severity::Error).collect();
    let right = match errors.as_slice() {
        [error] => {
            let label =
                error.labels.first().map(|label| checked.sources.get(label.span.source).name.as_path());
            error.code == code && label == Some(Path::new(place))
        }
        _ => false,
    };
    // The other renderings must hold for every diagnostic as well.
    assert!(
        github(&checked.sources, &checked.sink.diagnostics).lines().count() == checked.sink.diagnostics.len()
    );
    assert_eq!(json(&checked.sources, &checked.sink.diagnostics)["errors"], errors.len());
    let printed = human(&checked.sources, &checked.sink.diagnostics, Look::default());
    (!right).then(|| format!("expected {code} in {place}, found {} errors\n{printed}", errors.len()))
}

fn lines(mistake: &Mistake, prefix: &str) -> String {
    mistake.lines.iter().fold(String::new(), |mut text, (path, value)| {
        let _ = writeln!(text, "{prefix}{path} = {value}");
        text
    })
}

/// The complaints about a way of making every mistake.
fn complaints(way: impl Fn(&Mistake) -> Option<String>) -> Vec<String> {
    let named =
        |mistake: &Mistake| way(mistake).map(|complaint| format!("{}{complaint}", lines(mistake, "")));
    MISTAKES.iter().filter_map(named).collect()
}

fn assert_none(complaints: &[String]) {
    assert!(complaints.is_empty(), "{} of {}:\n{}", complaints.len(), MISTAKES.len(), complaints.join("\n"));
}

#[test]
fn a_mistake_in_the_spec_is_one_error_there() {
    assert_none(&complaints(|mistake| {
        let text = format!("{HEAD}extends = \"whole.toml\"\n{}", lines(mistake, ""));
        verdict(&check(&[("spec.toml", &text)], &LoadOptions::default()), mistake.code, "spec.toml")
    }));
}

#[test]
fn a_mistake_in_a_parent_is_one_error_in_the_parent() {
    assert_none(&complaints(|mistake| {
        let parent = format!("{HEAD}extends = \"whole.toml\"\n{}", lines(mistake, ""));
        let child = format!("{HEAD}extends = \"parent.toml\"\n[learn]\nlambda = 0.9\n");
        let checked = check(&[("spec.toml", &child), ("parent.toml", &parent)], &LoadOptions::default());
        verdict(&checked, mistake.code, "parent.toml")
    }));
}

#[test]
fn a_mistake_in_a_profile_is_one_error_in_the_profile() {
    assert_none(&complaints(|mistake| {
        if mistake.lines[0].0.starts_with("allow") {
            return None;
        }
        let text = format!("{HEAD}extends = \"whole.toml\"\n{}", lines(mistake, "profile.odd."));
        let options = LoadOptions { profile: Some("odd".to_owned()), ..LoadOptions::default() };
        verdict(&check(&[("spec.toml", &text)], &options), mistake.code, "spec.toml")
    }));
}

#[test]
fn a_mistake_on_the_command_line_is_one_error_there() {
    assert_none(&complaints(|mistake| {
        let text = format!("{HEAD}extends = \"whole.toml\"\n");
        let sets = mistake.lines.iter().map(|(path, value)| format!("{path}={value}")).collect();
        let options = LoadOptions { sets, ..LoadOptions::default() };
        verdict(&check(&[("spec.toml", &text)], &options), mistake.set, "--set")
    }));
}

#[test]
fn a_mistake_in_the_text_is_one_error() {
    let complaint = |(text, code): &(&str, &str)| {
        let checked = check(&[("spec.toml", text)], &LoadOptions::default());
        verdict(&checked, code, "spec.toml").map(|complaint| format!("{text}{complaint}"))
    };
    let complaints: Vec<String> = TEXTS.iter().filter_map(complaint).collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn without_a_mistake_there_is_no_error() {
    let text = format!("{HEAD}extends = \"whole.toml\"\n");
    assert!(check(&[("spec.toml", &text)], &LoadOptions::default()).sink.diagnostics.is_empty());
}

/// Mistakes in the sections, the sweep and the claims of a suite; `# CODE` ends each line that has one.
const SUITE: &str = r#"spec = 1
suite = "ten / mistakes" # E0107
extends = "whole.toml"

[action]
std = "10 Hz" # E0203
delai = "4 ms" # E0102

[randomize.link_mass]
range = [0.5, 1.25] # E0102
scale = { uniform = [1.4, 0.6] } # E0210

[learn]
environments = 60 # E0507

[report]
compare = ["x.toml"] # E0102

[sweep]
seeds = [1, 2, 2] # E0705

[sweep.terrain]
flat = {}
slope = { terrain = { kind = "slope", friction = 1.0, angel = "5 deg", angle = "5 deg" } } # E0604

[sweep.exploration]
path = "action.delay"
values = ["2 ms", "4 ms"]

[[sweep.exclude]]
terrain = "slop" # E0702

[[claim]]
id = "first"
text = "Survival"
metric = "evaluate.nominal.survivl" # E0804
compare = { a = "terrain=flt", b = "terrain=slope" } # E0803
expect = "a > b"
test = "welsh" # E0301

[[claim]]
id = "first" # E0104
text = "Return"
metric = "learn.final_return"
arm = "terrain=flat"
expect = "a > 3"

[[claim]]
id = "third"
text = "Return"
metric = "learn.final_return"
arm = "terrain=flat"
expect = "a > 3"
ovr = "each" # E0102
"#;

#[test]
fn all_mistakes_of_a_suite_are_found_at_once() {
    let mut overlay = Overlay::new(Nowhere);
    overlay.hold(Path::new("whole.toml"), whole());
    overlay.hold(Path::new("suite.toml"), SUITE);
    let checked = specforge::check::suite_in(&overlay, Path::new("suite.toml"), &LoadOptions::default());
    let line = |start: usize| SUITE[..start].matches('\n').count() + 1;
    let mut found: Vec<(usize, &str)> = checked
        .sink
        .diagnostics
        .iter()
        .filter(|found| found.severity == Severity::Error)
        .map(|found| (found.labels.first().map_or(0, |label| line(label.span.start)), found.code))
        .collect();
    found.sort_unstable();
    let marked = SUITE.lines().enumerate().filter_map(|(at, text)| Some((at + 1, text.split_once(" # ")?.1)));
    let expected: Vec<(usize, &str)> = marked.collect();
    let printed = human(&checked.sources, &checked.sink.diagnostics, Look::default());
    assert_eq!(found, expected, "{printed}");
    assert!(checked.sound().is_none());
}
