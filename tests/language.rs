//! The language's manual by example: Markdown suites whose specs are checked and whose errors are expected.
//!
//! A suite in `tests/language/` is a list of cases, one per heading:
//!
//! * ` ```toml file=NAME.toml
//!   ` writes a file into the case's empty folder; the first file is the spec that is checked. `whole.toml`,
//!   a complete spec, lies in every folder.
//! * ` ```edit file=NAME of=PATH ` writes a changed copy of a file of this repository; each line is `OLD =>
//!   NEW`.
//! * `# error: [E0203] 14` in a line expects that diagnostic there, its column optional; `# warning:`
//!   likewise; `# error nowhere: [E0706]` expects one without a place, `# error in --set: [E0604]` one in the
//!   argument. All of them, and no others, must be found.
//! * A line `Arguments: --profile quick --set learn.seed=2` chooses a variant; spaces in a value are written
//!   `_`.
//! * A ` ```text ` block is what is printed.
//! * A ` ```console ` block holds commands, each a line `$ specforge
//!   ...` that is run in the case's folder, and what they print.
//! * A ` ```toml include=FILE ` block is a file of `tests/language/` that only the document shows.
//!
//! `SPECFORGE_BLESS=1 cargo test --test language` rewrites the printed texts and
//! `docs/reference/language.md`, which is made of the suites.

#[path = "language/document.rs"]
mod document;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use specforge::check::{self, Checker, unrunnable};
use specforge::diag::render::{Look, human};
use specforge::diag::{Severity, Sink, SourceId, Sources};
use specforge::spec::{LoadOptions, suite};
use specforge::syntax::Disk;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A part of a suite, as it stands in the file.
#[derive(Debug)]
enum Part {
    Heading(String),
    Block { info: String, body: String },
    Prose(String),
}

fn parts(text: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(info) = line.strip_prefix("```") {
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            let body = body.iter().map(|line| format!("{line}\n")).collect();
            parts.push(Part::Block { info: info.to_owned(), body });
        } else if let Some(heading) = line.strip_prefix("## ") {
            parts.push(Part::Heading(heading.to_owned()));
        } else {
            parts.push(Part::Prose(line.to_owned()));
        }
    }
    parts
}

/// What checking a spec or a suite found.
struct Found {
    sources: Sources,
    sink: Sink,
}

/// One case of a suite.
#[derive(Default)]
struct Case {
    files: Vec<(PathBuf, String)>,
    options: LoadOptions,
}

impl Case {
    fn of(parts: &[Part]) -> Self {
        let mut case = Self::default();
        for part in parts {
            match part {
                Part::Block { info, body } => case.take(info, body),
                Part::Prose(line) => {
                    if let Some(arguments) = line.strip_prefix("Arguments: ") {
                        case.options = options(arguments.trim_matches('`'));
                    }
                }
                Part::Heading(_) => {}
            }
        }
        case
    }

    fn take(&mut self, info: &str, body: &str) {
        let word = |key: &str| info.split_whitespace().find_map(|word| word.strip_prefix(key));
        let Some(file) = word("file=") else { return };
        let text = match word("of=") {
            None => body.to_owned(),
            Some(original) => {
                edited(&fs::read_to_string(root().join(original)).expect("the original exists"), body)
            }
        };
        self.files.push((file.into(), text));
    }

    /// Writes the files and checks the first one. Names of files begin at the case's folder.
    fn run(&self, folder: &Path, checker: &mut Checker) -> (Found, Vec<(PathBuf, String)>) {
        let mut files = self.files.clone();
        let whole =
            fs::read_to_string(root().join("tests/language/whole.toml")).expect("whole.toml is readable");
        files.push(("whole.toml".into(), whole));
        for (name, text) in &files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().expect("a file has a folder")).expect("folders can be made");
            fs::write(path, text).expect("files can be written");
        }
        let path = folder.join(&files[0].0);
        if suite::is_suite(&files[0].1) {
            let result = check::suite(&path, &self.options);
            return (Found { sources: result.sources, sink: result.sink }, files);
        }
        let mut result = checker.check(&Disk, &path, &self.options);
        let reason =
            result.experiment.as_ref().and_then(|experiment| unrunnable(experiment, &result.sources));
        if !result.sink.has_errors() {
            result.sink.diagnostics.extend(reason);
        }
        (Found { sources: result.sources, sink: result.sink }, files)
    }
}

fn edited(original: &str, edits: &str) -> String {
    edits.lines().fold(original.to_owned(), |text, edit| {
        let (old, new) = edit.split_once(" => ").expect("an edit is OLD => NEW");
        assert!(text.contains(old), "nothing to edit: {old}");
        text.replacen(old, new, 1)
    })
}

fn options(arguments: &str) -> LoadOptions {
    let mut options = LoadOptions::default();
    let mut words = arguments.split_whitespace().map(|word| word.replace('_', " "));
    while let Some(word) = words.next() {
        match word.as_str() {
            "--profile" => options.profile = words.next(),
            "--set" => options.sets.extend(words.next().map(|word| word.replace("\\ ", "_"))),
            "--deny" => options.deny_warnings = words.next().is_some(),
            other => panic!("unknown argument {other}"),
        }
    }
    options
}

/// A diagnostic in a place: `error E0203 specs/x.toml 6 14`; without a column when none is expected.
fn expected(files: &[(PathBuf, String)]) -> BTreeSet<String> {
    let mut expected = BTreeSet::new();
    for (name, text) in files {
        for (index, line) in text.lines().enumerate() {
            for severity in ["error", "warning"] {
                for rest in line.split(&format!("# {severity}: [")).skip(1) {
                    let (code, rest) = rest.split_once(']').expect("a code ends with a bracket");
                    let column: String = rest.trim_start().chars().take_while(char::is_ascii_digit).collect();
                    let place = format!("{severity} {code} {} {}", name.display(), index + 1);
                    expected.insert(if column.is_empty() { place } else { format!("{place} {column}") });
                }
                for (elsewhere, place) in [("nowhere", ""), ("in --set", " --set 1")] {
                    for rest in line.split(&format!("# {severity} {elsewhere}: [")).skip(1) {
                        let code = rest.split(']').next().expect("a code ends with a bracket");
                        expected.insert(format!("{severity} {code}{place}"));
                    }
                }
            }
        }
    }
    expected
}

/// What was found, in the form of `expected`; a column is given only where it is expected.
fn found(checked: &Found, folder: &Path, expected: &BTreeSet<String>) -> BTreeSet<String> {
    let name = |id: SourceId| shown(&checked.sources.get(id).name.display().to_string(), folder);
    let one = |diagnostic: &specforge::diag::Diagnostic| {
        let severity = if diagnostic.severity == Severity::Error { "error" } else { "warning" };
        let Some(label) = diagnostic.labels.first() else { return format!("{severity} {}", diagnostic.code) };
        let [start, _] = checked.sources.positions(label.span);
        let place = format!("{severity} {} {} {}", diagnostic.code, name(label.span.source), start.line);
        if expected.contains(&place) { place } else { format!("{place} {}", start.column) }
    };
    checked.sink.diagnostics.iter().map(one).collect()
}

/// A text in which paths begin at the case's folder.
fn shown(text: &str, folder: &Path) -> String {
    text.replace(&format!("{}/", folder.display()), "")
}

/// Runs one suite; returns what is wrong with it, and rewrites its pinned texts when blessed.
fn run_suite(path: &Path, checker: &mut Checker) -> Vec<String> {
    let text = fs::read_to_string(path).expect("suites are readable");
    let mut parts = parts(&text);
    let bless = std::env::var_os("SPECFORGE_BLESS").is_some();
    let mut wrong = Vec::new();
    let starts: Vec<usize> = (0..parts.len()).filter(|at| matches!(parts[*at], Part::Heading(_))).collect();
    for (number, start) in starts.iter().enumerate() {
        let end = starts.get(number + 1).copied().unwrap_or(parts.len());
        let case = Case::of(&parts[*start..end]);
        if case.files.is_empty() {
            continue;
        }
        let Part::Heading(heading) = &parts[*start] else { unreachable!("starts are headings") };
        let title = format!("{}: {heading}", path.file_name().unwrap_or_default().to_string_lossy());
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (checked, files) = case.run(folder.path(), checker);
        let expected = expected(&files);
        let found = found(&checked, folder.path(), &expected);
        let printed =
            shown(&human(&checked.sources, &checked.sink.diagnostics, Look::default()), folder.path());
        if found != expected {
            let missed: Vec<_> = expected.difference(&found).collect();
            let surprising: Vec<_> = found.difference(&expected).collect();
            wrong.push(format!("{title}\n  missed {missed:?}\n  surprising {surprising:?}\n{printed}"));
        }
        for part in &mut parts[*start..end] {
            let Part::Block { info, body } = part else { continue };
            let printed = match info.as_str() {
                "text" => format!("{}\n", printed.trim_end()),
                "console" => console(body, folder.path()),
                _ => continue,
            };
            if *body == printed {
                continue;
            }
            if bless {
                *body = printed;
            } else {
                wrong.push(format!("{title}\n  prints\n{printed}\n  instead of\n{body}"));
            }
        }
    }
    if bless {
        fs::write(path, write(&parts)).expect("suites are writable");
    }
    wrong
}

/// The commands of a block with what they print now.
fn console(block: &str, folder: &Path) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_specforge")).parent().expect("the program lies in a folder");
    let path =
        std::env::join_paths([program, Path::new("/usr/bin"), Path::new("/bin")]).expect("plain folders");
    let mut text = String::new();
    for command in block.lines().filter_map(|line| line.strip_prefix("$ ")) {
        let mut shell = Command::new("sh");
        let shell =
            shell.args(["-c", &format!("exec 2>&1; {command}")]).current_dir(folder).env("PATH", &path);
        let output = shell.output().expect("the shell can be started");
        let printed = shown(&String::from_utf8_lossy(&output.stdout), folder);
        let _ = writeln!(text, "$ {command}");
        text.extend(printed.trim_end().lines().map(|line| format!("{}\n", line.trim_end())));
    }
    text
}

fn write(parts: &[Part]) -> String {
    let mut text = String::new();
    for part in parts {
        let _ = match part {
            Part::Heading(heading) => writeln!(text, "## {heading}"),
            Part::Block { info, body } => writeln!(text, "```{info}\n{body}```"),
            Part::Prose(line) => writeln!(text, "{line}"),
        };
    }
    text
}

/// All suites of the folder.
fn suites() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("tests/language")).expect("the suites are there");
    let mut suites: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    suites.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    suites.sort();
    suites
}

#[test]
fn suites_find_what_they_expect_and_nothing_else_and_the_document_is_made_of_them() {
    let mut checker = Checker::default();
    let wrong: Vec<String> = suites().iter().flat_map(|path| run_suite(path, &mut checker)).collect();
    assert!(wrong.is_empty(), "{} cases:\n{}", wrong.len(), wrong.join("\n"));
    let path = root().join("docs/reference/language.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, document::page()).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == document::page(),
        "docs/reference/language.md is stale: run SPECFORGE_BLESS=1 cargo test --test language"
    );
}

#[test]
fn every_suite_is_a_chapter_of_the_document() {
    let chapters: Vec<PathBuf> = document::CHAPTERS.iter().map(|chapter| document::path(chapter)).collect();
    let strays: Vec<PathBuf> = suites().into_iter().filter(|suite| !chapters.contains(suite)).collect();
    assert!(strays.is_empty(), "not in `CHAPTERS` of tests/language/document.rs: {strays:?}");
}

#[test]
fn writing_a_suite_gives_back_what_was_read() {
    for path in suites() {
        let text = fs::read_to_string(&path).expect("suites are readable");
        assert_eq!(write(&parts(&text)), text, "{}", path.display());
    }
}

#[test]
fn expectations_are_read_from_comments() {
    let text = "a = 1\nb = 2 # error: [E0203] 14 # warning: [W0501]\n# error nowhere: [E0706]\n";
    let expected = expected(&[("x.toml".into(), text.to_owned())]);
    assert_eq!(
        expected.into_iter().collect::<Vec<_>>(),
        ["error E0203 x.toml 2 14", "error E0706", "warning W0501 x.toml 2"]
    );
}
