//! The documents of the repository name files that exist, their links and anchors resolve, and the book has
//! every page.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const TOP: &[&str] = &["src/", "specs/", "robots/", "templates/", "tests/", "docs/", "tools/", ".ci/"];

/// Pages whose back-quoted paths are those of examples.
const EXAMPLES: &[&str] = &["docs/reference/codes.md", "docs/reference/kinds.md"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Markdown files of a folder; `deep`: of its subfolders, too.
fn markdown(folder: &Path, deep: bool) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() && deep {
            found.extend(markdown(&path, true));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The documents: those at the top and below `docs/`.
fn documents() -> impl Iterator<Item = PathBuf> {
    markdown(root(), false).into_iter().chain(markdown(&root().join("docs"), true))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The path as people write it.
fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// The paths in back quotes that begin with a folder of the repository. What has a placeholder (`NAME`, `*`,
/// `{`, `<`) names no file.
fn quoted(text: &str) -> Vec<String> {
    let words = text.split('`').skip(1).step_by(2).filter(|word| TOP.iter().any(|top| word.starts_with(top)));
    let clean =
        |word: &str| word.split(['#', ' ']).next().unwrap_or_default().trim_end_matches('/').to_owned();
    let placeholder = |word: &String| {
        word.contains(['*', '{', '<', '$', '\n'])
            || word.contains("...")
            || word.split(['/', '.']).any(is_shouted)
    };
    words.map(clean).filter(|word| !placeholder(word)).collect()
}

/// The targets of the links that stay in the repository.
fn linked(text: &str) -> Vec<String> {
    let targets = text.match_indices("](").filter_map(|(at, _)| text[at + 2..].split(')').next());
    targets.filter(|target| !target.contains("://")).map(str::to_owned).collect()
}

/// The text without its fenced blocks, indented ones as well: examples and transcripts name files of their
/// own.
fn without_blocks(text: &str) -> String {
    let (mut fence, mut lines) = (None, Vec::new());
    for line in text.lines() {
        let ticks = line.trim_start().chars().take_while(|c| *c == '`').count();
        match fence {
            None if ticks >= 3 => fence = Some(ticks),
            Some(open) if ticks >= open && line.trim().len() == ticks => fence = None,
            None => lines.push(line),
            Some(_) => {}
        }
    }
    lines.join("\n")
}

/// The text without what stands in back quotes.
fn without_code(text: &str) -> String {
    text.split('`').step_by(2).collect::<Vec<_>>().join(" ")
}

/// The anchors of a page's headings, as GitHub and mdBook build them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut all = BTreeSet::new();
    for line in without_blocks(text).lines().filter(|line| line.starts_with('#')) {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let slug: String = title
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect();
        let count = seen.entry(slug.clone()).or_default();
        all.insert(if *count == 0 { slug } else { format!("{slug}-{count}") });
        *count += 1;
    }
    all
}

/// What is wrong with a link from a page, if anything.
fn fault(page: &Path, text: &str, target: &str) -> Option<String> {
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = if file.is_empty() { page.to_owned() } else { page.parent().unwrap_or(root()).join(file) };
    if !path.exists() {
        return Some(format!("{}: no file {target}", shown(page)));
    }
    if anchor.is_empty() {
        return None;
    }
    let known = if file.is_empty() { anchors(text) } else { anchors(&read(&path)) };
    (!known.contains(anchor)).then(|| format!("{}: no heading {target}", shown(page)))
}

/// A word in capitals stands for something else, but for the few files that are named so.
fn is_shouted(part: &str) -> bool {
    let known = ["README", "ARCHITECTURE", "CONTRIBUTING", "NEWS", "LICENSE", "SUMMARY"];
    !known.contains(&part) && part.len() > 2 && part.chars().all(|c| c.is_ascii_uppercase() || c == '_')
}

#[test]
fn paths_in_documents_exist() {
    let mut missing = Vec::new();
    for document in documents().filter(|path| !EXAMPLES.iter().any(|page| path.ends_with(page))) {
        for path in quoted(&without_blocks(&read(&document))) {
            if !root().join(&path).exists() {
                missing.push(format!("{}: {path}", shown(&document)));
            }
        }
    }
    assert!(missing.is_empty(), "documents name files that do not exist: {missing:#?}");
}

#[test]
fn links_and_their_anchors_resolve() {
    let mut faults = Vec::new();
    let policies = root().join("reports/policies/README.md");
    for document in documents().chain([policies]) {
        let text = read(&document);
        let links = linked(&without_code(&without_blocks(&text)));
        faults.extend(links.iter().filter_map(|target| fault(&document, &text, target)));
    }
    assert!(faults.is_empty(), "broken links: {faults:#?}");
}

#[test]
fn the_summary_lists_every_page_once() {
    let docs = root().join("docs");
    let listed = linked(&read(&docs.join("SUMMARY.md")));
    let unique: BTreeSet<PathBuf> = listed.iter().map(|page| docs.join(page)).collect();
    assert_eq!(unique.len(), listed.len(), "a page is listed twice");
    let pages: BTreeSet<PathBuf> =
        markdown(&docs, true).into_iter().filter(|page| !page.ends_with("SUMMARY.md")).collect();
    let unlisted: Vec<String> = pages.difference(&unique).map(|page| shown(page)).collect();
    assert!(unlisted.is_empty(), "pages that docs/SUMMARY.md does not list: {unlisted:#?}");
}

#[test]
fn sources_and_specs_name_pages_that_exist() {
    fn files(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                files(&path, found);
            } else if path.extension().is_some_and(|ending| ["rs", "toml", "md"].iter().any(|e| ending == *e))
            {
                found.push(path);
            }
        }
    }
    let mut all = Vec::new();
    ["src", "specs", "benches", "robots", "templates"]
        .iter()
        .for_each(|top| files(&root().join(top), &mut all));
    let page = |c: char| c.is_ascii_alphanumeric() || "/-_.".contains(c);
    let mut missing = Vec::new();
    for path in all {
        let text = read(&path);
        for (at, _) in text.match_indices("docs/") {
            let word: String = text[at..].chars().take_while(|c| page(*c)).collect();
            let word = word.trim_end_matches(['.', '/']);
            let within = text[..at].chars().next_back().is_some_and(page);
            if !within && word.ends_with(".md") && !root().join(word).exists() {
                missing.push(format!("{}: {word}", shown(&path)));
            }
        }
    }
    assert!(missing.is_empty(), "pages that do not exist are named: {missing:#?}");
}

#[test]
fn placeholders_are_not_paths() {
    let text = "`robots/NAME.toml` `src/main.rs` `specs/*.toml` `src/a b`";
    assert_eq!(quoted(text), ["src/main.rs", "src/a"]);
}

#[test]
fn links_without_their_file_or_heading_are_found() {
    let page = root().join("docs/README.md");
    let text = "# One `two`\n\n```toml\n# no heading\n```\n\n## Three\n## Three\n[a](guide/none.md) [b](#one-two)\n\
        [c](#four) [d](../README.md) [e](https://f.g/h.md) [i](#three-1)";
    assert_eq!(anchors(text).len(), 3);
    let faults: Vec<String> = linked(text).iter().filter_map(|target| fault(&page, text, target)).collect();
    assert_eq!(faults, ["docs/README.md: no file guide/none.md", "docs/README.md: no heading #four"]);
}
