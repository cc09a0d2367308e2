//! Every code has a page, every page has its sections, and `docs/reference/codes.md` is what the pages say.
//!
//! `SPECFORGE_BLESS=1 cargo test --test codes` rewrites the document.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use specforge::diag::codes::{PAGES, Page};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files below a folder whose names end in one of `endings`, sorted.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, endings));
        } else if endings.iter().any(|ending| path.to_string_lossy().ends_with(ending)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The words of the form `E0203` in a text.
fn codes_in(text: &str) -> BTreeSet<String> {
    let bytes = text.as_bytes();
    let word = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    (0..bytes.len().saturating_sub(4))
        .filter(|&at| {
            b"EWR".contains(&bytes[at])
                && bytes[at + 1..at + 5].iter().all(u8::is_ascii_digit)
                && !word(bytes.get(at + 5))
                && !word(at.checked_sub(1).and_then(|before| bytes.get(before)))
        })
        .map(|at| text[at..at + 5].to_owned())
        .collect()
}

/// The text of a source file before and after its tests begin.
fn split_tests(text: &str) -> (&str, &str) {
    text.split_at(text.find("#[cfg(test)]").unwrap_or(text.len()))
}

fn document() -> String {
    let mut text = String::from(
        "# Diagnostic codes\n\nEvery diagnostic has a code; `specforge explain CODE` prints its page. Codes that \
         begin with E are errors, with W\nwarnings, and with R errors of a running stage. This page is \
         generated from `src/diag/codes/`.\n\n",
    );
    for page in PAGES {
        let anchor = format!("{}-{}", page.code.to_lowercase(), slug(page.title()));
        text += &format!("- [{}](#{anchor}) {}\n", page.code, page.title());
    }
    for page in PAGES {
        text += &format!("\n{}", page.text.replace("\n## ", "\n### ").replacen("# ", "## ", 1));
    }
    text
}

/// A heading as GitHub turns it into an anchor.
fn slug(title: &str) -> String {
    let kept = title.to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

#[test]
fn every_code_in_the_source_has_a_page() {
    let known: BTreeSet<&str> = PAGES.iter().map(|page| page.code).collect();
    let mut missing = BTreeSet::new();
    for path in files(&root().join("src"), &[".rs"]) {
        let text = fs::read_to_string(&path).expect("sources are readable");
        let (code, _) = split_tests(&text);
        for found in codes_in(code).into_iter().filter(|found| !known.contains(found.as_str())) {
            missing.insert(format!("{found} in {}", path.strip_prefix(root()).unwrap_or(&path).display()));
        }
    }
    assert!(missing.is_empty(), "codes without a page in src/diag/codes/: {missing:#?}");
}

#[test]
fn every_code_is_exercised_by_a_test() {
    let mut exercised = BTreeSet::new();
    for path in files(&root().join("src"), &[".rs"]) {
        let text = fs::read_to_string(&path).expect("sources are readable");
        let (code, tests) = split_tests(&text);
        let all_tests = path.file_stem().is_some_and(|stem| stem == "tests")
            || path.parent().is_some_and(|p| p.ends_with("tests"));
        exercised.extend(codes_in(if all_tests { code } else { tests }));
    }
    let this = root().join("tests/codes.rs");
    for path in files(&root().join("tests"), &[".rs", ".md"]).into_iter().filter(|path| *path != this) {
        exercised.extend(codes_in(&fs::read_to_string(&path).expect("tests are readable")));
    }
    let idle: Vec<&str> =
        PAGES.iter().map(|page| page.code).filter(|code| !exercised.contains(*code)).collect();
    assert!(idle.is_empty(), "no test exercises {idle:?}");
}

#[test]
fn every_page_is_listed_once_and_in_order() {
    let listed: Vec<&str> = PAGES.iter().map(|page| page.code).collect();
    assert!(listed.is_sorted_by(|a, b| a < b), "{listed:?}");
    let on_disk: Vec<String> = files(&root().join("src/diag/codes"), &[".md"])
        .iter()
        .map(|path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned())
        .collect();
    assert_eq!(listed, on_disk);
}

#[test]
fn every_page_says_what_why_wrong_and_right() {
    for Page { code, text } in PAGES {
        assert!(text.starts_with(&format!("# {code}: ")), "the first line of {code}");
        let headings: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
        assert_eq!(headings, ["What", "Why", "Wrong", "Right"], "the sections of {code}");
    }
}

#[test]
fn what_a_page_calls_right_is_toml() {
    for Page { code, text } in PAGES {
        let (_, right) = text.split_once("## Right\n").expect("every page has the section");
        if let Some((_, block)) = right.split_once("```toml\n") {
            let block = block.split("```").next().unwrap_or_default();
            assert!(toml::from_str::<toml::Table>(block).is_ok(), "{code}: {block}");
        }
    }
}

#[test]
fn the_document_of_the_codes_is_up_to_date() {
    let path = root().join("docs/reference/codes.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, document()).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == document(),
        "docs/reference/codes.md is stale: run SPECFORGE_BLESS=1 cargo test --test codes"
    );
}
