//! `docs/reference/kinds.md` is what the descriptors say, and every kind has its page beside its file.
//!
//! `SPECFORGE_BLESS=1 cargo test --test kinds` rewrites the document.

use std::fs;
use std::path::Path;

use specforge::kinds::reference::{document, registries};

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
