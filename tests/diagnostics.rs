//! `docs/reference/diagnostics.md`: what specforge says to the mistakes that people make, each made in a copy
//! of
//! `specs/tocabi_walk_torque.toml` and its parents, or of a suite.
//! `SPECFORGE_BLESS=1 cargo test --test diagnostics` rewrites the page.

mod folders;

#[path = "diagnostics/edits.rs"]
mod edits;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use self::folders::copy;
use edits::{EDITS, Edit};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

const INTRODUCTION: &str = "\
# What specforge says to a mistake

Thirty mistakes that people make, each made in a copy of `specs/tocabi_walk_torque.toml` and its parents or \
of a suite of
`specs/paper/`, and the whole output for it. This page is written by `tests/diagnostics.rs`, which also \
checks that `--format json` and `--format github` tell
the same. The rules behind the messages are in [language.md](language.md), the pages of the codes in \
[codes.md](codes.md).

";

/// Makes the mistake.
fn make(edit: &Edit, folder: &Path) {
    for (file, changes) in edit.changes {
        let path = folder.join(file);
        let mut text = fs::read_to_string(&path).unwrap_or_default();
        for (old, new) in *changes {
            if old.is_empty() {
                text += new;
            } else {
                assert!(text.contains(old), "{}: nothing to edit: {old}", edit.title);
                text = text.replacen(old, new, 1);
            }
        }
        fs::create_dir_all(path.parent().expect("a file has a folder")).expect("folders can be made");
        fs::write(path, text).expect("files can be written");
    }
}

fn specforge(folder: &Path, arguments: &str, format: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let words = words(arguments);
    command
        .current_dir(folder)
        .args(words)
        .args(["--format", format])
        .output()
        .expect("the program can be started")
}

/// The words of a command line; double quotes hold blanks together.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            letter => words.last_mut().expect("there is one").push(letter),
        }
    }
    words
}

/// The edit as lines with `-` and `+`.
fn shown(edit: &Edit) -> String {
    let mut text = String::new();
    for (file, changes) in edit.changes {
        text += &format!("In {file}:\n\n```diff\n");
        for (old, new) in *changes {
            old.lines().for_each(|line| text += &format!("-{line}\n"));
            new.lines().for_each(|line| text += &format!("+{line}\n"));
        }
        text += "```\n\n";
    }
    text
}

/// The transcript of one mistake; the other formats must tell the same.
fn transcript(edit: &Edit) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy(&root().join("specs"), &folder.path().join("specs"));
    copy(&root().join("robots"), &folder.path().join("robots"));
    make(edit, folder.path());
    let human = specforge(folder.path(), edit.command, "human");
    assert_eq!(human.status.code(), Some(3), "{}: {}", edit.title, String::from_utf8_lossy(&human.stderr));
    let human = String::from_utf8(human.stderr).expect("messages are UTF-8");
    for code in edit.codes {
        assert!(human.contains(&format!("[{code}]")), "{}: {code} in\n{human}", edit.title);
    }
    assert_eq!(
        human.matches("error[").count(),
        edit.codes.len(),
        "{}: one cause, one error\n{human}",
        edit.title
    );
    agree(edit, folder.path(), &human);
    let text = human.lines().map(|line| format!("{}\n", line.trim_end())).collect::<String>();
    format!(
        "## {}\n\n{}\n\n{}```text\n$ specforge {}\n{text}```\n",
        edit.title,
        edit.why,
        shown(edit),
        edit.command
    )
}

/// JSON and GitHub's annotations name the same codes and places as the text for people.
fn agree(edit: &Edit, folder: &Path, human: &str) {
    let json = specforge(folder, edit.command, "json");
    let document: serde_json::Value = serde_json::from_slice(&json.stdout).expect("one JSON document");
    let diagnostics = document["diagnostics"].as_array().expect("a list");
    assert_eq!(diagnostics.len(), edit.codes.len(), "{}: {document:#}", edit.title);
    let github = specforge(folder, edit.command, "github");
    let github = String::from_utf8(github.stdout).expect("annotations are UTF-8");
    let lines: Vec<&str> = github.lines().collect();
    assert_eq!(lines.len(), edit.codes.len(), "{}: {github}", edit.title);
    for diagnostic in diagnostics {
        let code = diagnostic["code"].as_str().expect("a code");
        assert!(edit.codes.contains(&code), "{}: {code}", edit.title);
        assert!(
            diagnostic["help"].as_array().is_some_and(|help| !help.is_empty()),
            "{}: no cure",
            edit.title
        );
        assert!(lines.iter().any(|line| line.contains(code)), "{}: no annotation of {code}", edit.title);
        if let (Some(file), Some(line)) = (diagnostic["file"].as_str(), diagnostic["line"].as_u64()) {
            let column = diagnostic["column"].as_u64().expect("a place has a column");
            assert!(human.contains(&format!("{file}:{line}:{column}")), "{}: {diagnostic:#}", edit.title);
            let place = format!("file={file},line={line},");
            let annotated = lines.iter().any(|line| line.contains(code) && line.contains(&place));
            assert!(annotated, "{}: {place} in\n{github}", edit.title);
        }
    }
}

#[test]
fn the_page_of_mistakes_is_what_the_program_says() {
    let transcripts: Vec<String> = EDITS.iter().map(transcript).collect();
    let page = INTRODUCTION.to_owned() + &transcripts.join("\n");
    let path = root().join("docs/reference/diagnostics.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, &page).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "docs/reference/diagnostics.md is stale: run SPECFORGE_BLESS=1 cargo test --test diagnostics"
    );
}
