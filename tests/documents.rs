//! The documents of the repository name files that exist.

use std::fs;
use std::path::{Path, PathBuf};

const TOP: &[&str] = &["src/", "specs/", "robots/", "templates/", "tests/", "docs/", "tools/", ".ci/"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Markdown documents: those at the top and below `docs/`.
fn documents(folder: &Path, deep: bool) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() && deep {
            found.extend(documents(&path, true));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The paths in back quotes that begin with a folder of the repository, and the targets of relative links.
/// What has a placeholder (`NAME`, `*`, `{`, `<`) names no file, and what stands in `reports/` is written by
/// runs.
fn named(text: &str) -> Vec<String> {
    let quoted =
        text.split('`').skip(1).step_by(2).filter(|word| TOP.iter().any(|top| word.starts_with(top)));
    let linked = text.match_indices("](").filter_map(|(at, _)| {
        let target = text[at + 2..].split(')').next()?;
        (!target.contains("://") && !target.starts_with('#')).then_some(target)
    });
    let clean =
        |word: &str| word.split(['#', ' ']).next().unwrap_or_default().trim_end_matches('/').to_owned();
    let placeholder = |word: &String| {
        word.contains(['*', '{', '<', '$', '\n'])
            || word.contains("...")
            || word.split(['/', '.']).any(is_shouted)
    };
    let written = |word: &String| word.is_empty() || word.starts_with("reports/");
    quoted.chain(linked).map(clean).filter(|word| !written(word) && !placeholder(word)).collect()
}

/// The text without its fenced blocks, indented ones as well: examples and transcripts name files of their
/// own.
fn without_blocks(text: &str) -> String {
    let (mut inside, mut lines) = (false, Vec::new());
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            lines.push(line);
        }
    }
    lines.join("\n")
}

/// A word in capitals stands for something else, but for the few files that are named so.
fn is_shouted(part: &str) -> bool {
    let known = ["README", "ARCHITECTURE", "CONTRIBUTING", "NEWS", "LICENSE"];
    !known.contains(&part) && part.len() > 2 && part.chars().all(|c| c.is_ascii_uppercase() || c == '_')
}

#[test]
fn paths_in_documents_exist() {
    let mut missing = Vec::new();
    let all = documents(root(), false).into_iter().chain(documents(&root().join("docs"), true));
    for document in all.filter(|path| !path.ends_with("docs/codes.md") && !path.ends_with("docs/kinds.md")) {
        let text = without_blocks(&fs::read_to_string(&document).expect("documents are readable"));
        let beside = document.parent().unwrap_or(root()).to_owned();
        for path in named(&text) {
            if !root().join(&path).exists() && !beside.join(&path).exists() {
                missing.push(format!(
                    "{}: {path}",
                    document.strip_prefix(root()).unwrap_or(&document).display()
                ));
            }
        }
    }
    assert!(missing.is_empty(), "documents name what is not there: {missing:#?}");
}

#[test]
fn placeholders_are_not_paths() {
    let text = "`robots/NAME.toml` `src/main.rs` `specs/*.toml` [r](reports/a.md) [x](docs/a.md#b) \
        [y](https://x.y) `src/a b`";
    assert_eq!(named(text), ["src/main.rs", "src/a", "docs/a.md"]);
}
