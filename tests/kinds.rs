//! `docs/reference/kinds.md` is what the descriptors say, `docs/reference/synonyms.md` what the table of names says, and every kind has its page beside its file.
//!
//! `SPECFORGE_BLESS=1 cargo test --test kinds` rewrites the document.

use std::fs;
use std::path::Path;

use specforge::kinds::reference::{document, registries};
use specforge::spec::synonyms::{PARTS, shown};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_document_of_the_kinds_is_up_to_date() {
    let path = root().join("docs/reference/kinds.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, document()).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == document(),
        "docs/reference/kinds.md is stale: run SPECFORGE_BLESS=1 cargo test --test kinds"
    );
}

#[test]
fn a_kind_is_one_file_or_row_and_one_page_of_its_name() {
    // Those that differ by an expression are rows of one table.
    let tables = ["metric", "statistic"];
    for registry in registries() {
        for kind in registry.kinds {
            let endings: &[&str] = if tables.contains(&registry.name) { &["md"] } else { &["rs", "md"] };
            for ending in endings {
                let path = root().join(format!("src/kinds/{}/{}.{ending}", registry.name, kind.name));
                assert!(path.is_file(), "{} is missing", path.display());
            }
        }
    }
}

/// The page of the names that other programs use.
fn synonyms() -> String {
    let mut text = String::from(
        "# Names in other programs\n\nWhat users of legged_gym, Isaac Lab and Stable-Baselines3 look for, and what it \
         is called in a spec. `specforge\nexplain` knows these names, and the messages of E0102, E0301 and E0604 \
         suggest ours for them. This page is\ngenerated from `src/spec/synonyms.rs`.\n",
    );
    let quoted =
        |names: Vec<String>| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    for part in PARTS {
        text += &format!("\n## {}\n\n| elsewhere | here | difference |\n|---|---|---|\n", part.title);
        for row in part.rows {
            let theirs = quoted(row.theirs.iter().map(|name| (*name).to_owned()).collect());
            let ours = quoted(row.ours.iter().map(|path| shown(path)).collect());
            text += &format!("| {theirs} | {ours} | {} |\n", row.note);
        }
    }
    text
}

#[test]
fn the_page_of_synonyms_is_up_to_date() {
    let path = root().join("docs/reference/synonyms.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, synonyms()).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == synonyms(),
        "docs/reference/synonyms.md is stale: run SPECFORGE_BLESS=1 cargo test --test kinds"
    );
}
