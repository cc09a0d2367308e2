//! The page that is there already: a report that lacks results does not take the place of one that knows more.

use std::path::{Path, PathBuf};

use crate::report::sidecar::Sidecar;

/// The record beside a report's page.
pub fn record(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.json"))
}

/// That the page of a record has more results than a report that would take its place.
pub fn fuller(record: &Path, results: usize) -> Option<String> {
    let known = results_of(record).filter(|known| *known > results)?;
    let page = record.with_extension("md");
    Some(format!("{} has {known} results, and this report would have {results}", page.display()))
}

/// How many results there are in a report's record; none when it cannot be read.
pub fn results_of(record: &Path) -> Option<usize> {
    let sidecar: Sidecar = serde_json::from_str(&std::fs::read_to_string(record).ok()?).ok()?;
    Some(sidecar.results())
}
