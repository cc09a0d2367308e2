//! `docs/reference/language.md`: what the suites show to be right, as one page for readers, without the
//! annotations that the test reads. Of the cases with a mistake it has the names alone, with their codes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use specforge::diag::codes::PAGES;

use super::{Part, parts, root};

/// The chapters in reading order; each is a suite of this folder.
pub const CHAPTERS: &[&str] = &[
    "files",
    "keys",
    "quantities",
    "samplers",
    "kinds",
    "robots",
    "control",
    "evaluations",
    "fine_tuning",
    "extends",
    "profiles",
    "sweeps",
    "claims",
    "suspicious",
    "templates",
];

/// Cases that the page shows although they have a mistake.
const SHOWN: &[&str] = &["Reading a diagnostic", "Importing a robot"];

const INTRODUCTION: &str = "\
# The spec language

A spec is a TOML file that describes one experiment with a robot: which robot, in which physics, with which \
task, actions,
observations and rewards, how it learns and how it is judged. This page explains the language chapter by \
chapter, with an
example of each form. The keys of every kind are in [kinds.md](kinds.md); `specforge explain` prints them in \
the terminal.

Each chapter ends with the mistakes that are recognised, and links to the code that explains them and says how \
to fix them.
[Common mistakes and their messages](diagnostics.md) shows the messages.

This page is generated from `tests/language/`, where each example is checked, and the message of each mistake \
compared letter
by letter.

";

/// The suite of a chapter.
pub fn path(chapter: &str) -> PathBuf {
    root().join("tests/language").join(format!("{chapter}.md"))
}

/// The whole page.
pub fn page() -> String {
    let suites = CHAPTERS.iter().map(|chapter| path(chapter)).filter(|suite| suite.is_file());
    let chapters: Vec<(String, String)> = suites.map(|suite| numbered(&suite)).collect();
    let mut page = INTRODUCTION.to_owned();
    for (number, (title, _)) in chapters.iter().enumerate() {
        page += &format!("{}. [{title}](#{}-{})\n", number + 1, number + 1, anchor(title));
    }
    for (number, (title, body)) in chapters.iter().enumerate() {
        page += &format!("\n## {}. {title}\n{body}", number + 1);
    }
    page
}

/// Title and body of a suite.
fn numbered(path: &Path) -> (String, String) {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let (title, rest) = text.split_once('\n').expect("a suite has a title");
    let title = title.strip_prefix("# ").expect("a suite begins with its title").to_owned();
    let parts = parts(rest);
    let mut body = String::new();
    let mut mistakes = Vec::new();
    for case in parts.chunk_by(|_, next| !matches!(next, Part::Heading(_))) {
        match (&case[0], mistake(case)) {
            (Part::Heading(heading), Some(codes)) => mistakes.push((heading.as_str(), codes)),
            _ => case.iter().for_each(|part| body += &printed(part)),
        }
    }
    if !mistakes.is_empty() {
        body += "### Mistakes\n\n| mistake | code |\n|---|---|\n";
        for (heading, codes) in mistakes {
            let codes: Vec<String> = codes.iter().map(|code| link(code)).collect();
            body += &format!("| {heading} | {} |\n", codes.join(", "));
        }
    }
    (title, body)
}

/// The codes of a case with a mistake; `None` for a case that the page shows.
fn mistake(case: &[Part]) -> Option<BTreeSet<&str>> {
    let Part::Heading(heading) = &case[0] else { return None };
    let blocks = case.iter().filter_map(|part| match part {
        Part::Block { body, .. } => Some(body.as_str()),
        _ => None,
    });
    let marks =
        ["# error: [", "# warning: [", "# error nowhere: [", "# error in --set: [", "error[", "warning["];
    let codes: BTreeSet<&str> = blocks
        .flat_map(|block| marks.iter().flat_map(|mark| block.split(mark).skip(1)))
        .filter_map(|rest| rest.split(']').next())
        .collect();
    (!codes.is_empty() && !SHOWN.contains(&heading.as_str())).then_some(codes)
}

/// A code with a link to its page in `codes.md`.
fn link(code: &str) -> String {
    let page = PAGES.iter().find(|page| page.code == code).unwrap_or_else(|| panic!("no page for {code}"));
    let heading = page.text.lines().next().unwrap_or_default().trim_start_matches("# ");
    format!("[{code}](codes.md#{})", anchor(heading))
}

/// A part as the page has it.
fn printed(part: &Part) -> String {
    match part {
        Part::Heading(heading) => format!("### {heading}\n"),
        Part::Prose(line) => format!("{}\n", prose(line)),
        Part::Block { info, body } => fenced(info, body),
    }
}

/// A line of prose; the arguments of a case become a sentence.
fn prose(line: &str) -> String {
    let Some(arguments) = line.strip_prefix("Arguments: ") else { return line.to_owned() };
    let words: Vec<String> = arguments.split_whitespace().map(argument).collect();
    format!("With `{}`:", words.join(" "))
}

/// An argument as one types it: blanks are written `_` in the suites, and need quotes in a terminal.
fn argument(word: &str) -> String {
    let word = word.replace("\\_", "\0").replace('_', " ").replace('\0', "_");
    if word.contains(' ') { format!("\"{word}\"") } else { word }
}

/// A block, with the name of its file above it unless that is the spec itself.
fn fenced(info: &str, block: &str) -> String {
    let word = |key: &str| info.split_whitespace().find_map(|word| word.strip_prefix(key));
    let language = info.split_whitespace().next().unwrap_or_default();
    let caption = match (word("file="), word("of=")) {
        (Some(file), Some(original)) => format!("**{file}**, a copy of `{original}` with these changes:\n\n"),
        (Some("spec.toml") | None, _) => String::new(),
        (Some(file), None) => format!("**{file}**\n\n"),
    };
    let (language, block) = match word("include=") {
        Some(file) => (
            language,
            fs::read_to_string(root().join("tests/language").join(file)).expect("the included file is there"),
        ),
        None => (if language == "edit" { "text" } else { language }, plain(block)),
    };
    format!("{caption}```{language}\n{block}```\n")
}

/// The lines without what the test expects of them.
fn plain(block: &str) -> String {
    let cut = |line: &str| {
        let marks = ["# error: [", "# warning: [", "# error nowhere: [", "# error in --set: ["];
        let at = marks.iter().filter_map(|mark| line.find(mark)).min();
        at.map_or(line, |at| line[..at].trim_end()).to_owned() + "\n"
    };
    block.lines().filter(|line| !is_only_a_mark(line)).map(cut).collect()
}

/// Whether a line is there only for the test.
fn is_only_a_mark(line: &str) -> bool {
    line.starts_with("# error nowhere: [") || line.starts_with("# error in --set: [")
}

/// A heading as GitHub turns it into an anchor.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}
