//! Whether a folder of reports is as it was published: every record with its own digest, its page, its figures, its
//! name and place and the verdicts that its values give; the index; and nothing of ours that no record lists. What
//! lacks a digest is told apart from what agrees with one.

mod index;
mod record;
mod stray;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::index::mark;
use super::listing;
use super::sidecar::{RecordError, Sidecar};
use crate::bounded;
use crate::exec::records;
use crate::seal::unsealed::Unsealed;

/// A file that is not as it was published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The path of the report's page in the folder of the reports, without `.md`.
    pub report: String,
    /// The path of the file in that folder.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
    /// What can be done.
    pub fix: String,
}

/// A report of which nobody can say whether it is as it was published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unverifiable {
    /// The path of its page in the folder of the reports, without `.md`.
    pub report: String,
    /// What it lacks.
    pub reason: &'static str,
}

/// What was found in a folder of reports.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// The records that can be read, by the path of the page without `.md`.
    pub records: BTreeMap<String, Sidecar>,
    /// The digests of their contents, by the same path.
    pub contents: BTreeMap<String, String>,
    /// Number of records of runs that are as they were written.
    pub runs: usize,
    /// Files that are not as they were published.
    pub faults: Vec<Fault>,
    /// What the next `specforge report --index` writes: the notice of earlier rules where a page lacks it, and the
    /// index where it is not what the records give.
    pub unwritten: Vec<Fault>,
    /// Reports without a fault that have no digests to agree with.
    pub unverifiable: Vec<Unverifiable>,
}

impl Found {
    /// The reports with a fault, and what `--index` has to write again.
    pub fn differing(&self) -> BTreeSet<&str> {
        self.faults.iter().chain(&self.unwritten).map(|fault| fault.report.as_str()).collect()
    }

    /// The reports that agree with all their digests.
    pub fn whole(&self) -> Vec<&str> {
        let differing = self.differing();
        let unverifiable: BTreeSet<&str> =
            self.unverifiable.iter().map(|found| found.report.as_str()).collect();
        let is_whole = |name: &&str| !differing.contains(name) && !unverifiable.contains(name);
        self.records.keys().map(String::as_str).filter(is_whole).collect()
    }
}

/// Reads every record in a folder and below it and compares it with its files. A folder that does not exist has none.
pub fn verify(folder: &Path) -> Found {
    verify_by(folder, Unsealed::known())
}

/// The same by a list of the records that may lack a digest of themselves.
pub fn verify_by(folder: &Path, unsealed: &Unsealed) -> Found {
    let mut found = Found::default();
    // The files that a record lists, from the folder of the reports.
    let mut listed = BTreeSet::new();
    let folders = listing::folders(folder);
    for below in &folders {
        let place = Place { folder, below, unsealed };
        let records = listing::files(below, "json");
        let has_pages = *below == folder || records.iter().any(|path| path.with_extension("md").is_file());
        for path in &records {
            match Sidecar::open_by(path, unsealed) {
                Ok((record, seal)) => place.record(record, &seal, path, &mut found, &mut listed),
                Err(error) => place.other(path, &error, has_pages, &mut found),
            }
        }
        place.pages_without_record(&mut found);
        place.figures_without_report(&mut found);
    }
    stray::copies(&mut found);
    for below in &folders {
        let place = Place { folder, below, unsealed };
        place.unlisted_figures(&listed, &mut found);
        place.index(&mut found);
    }
    let Found { faults, unverifiable, .. } = &mut found;
    unverifiable.retain(|unverifiable| faults.iter().all(|fault| fault.report != unverifiable.report));
    found
}

/// A folder of pages.
struct Place<'a> {
    /// The folder of all reports.
    folder: &'a Path,
    /// It, or one below it.
    below: &'a Path,
    /// The records that may lack a digest.
    unsealed: &'a Unsealed,
}

impl Place<'_> {
    /// A path of this place as seen from the folder of all reports.
    fn seen(&self, path: &Path) -> String {
        path.strip_prefix(self.folder).unwrap_or(path).display().to_string()
    }

    fn fault(&self, page: &Path, file: &Path, reason: impl Into<String>, fix: String) -> Fault {
        Fault { report: self.seen(page), file: self.seen(file), reason: reason.into(), fix }
    }

    /// A JSON file that is not the record of a report: that of a run, or something else in a folder without pages.
    fn other(&self, path: &Path, error: &RecordError, has_pages: bool, found: &mut Found) {
        match records::verify(path, self.unsealed) {
            Some(Ok(())) => found.runs += 1,
            Some(Err(reason)) => {
                let fix = "restore it from version control, or write it again: delete it and \
                           `specforge cache export SPEC --to DIR`";
                found.faults.push(self.fault(&path.with_extension(""), path, reason, fix.to_owned()));
            }
            None if has_pages => found.faults.push(self.unreadable(path, error)),
            None => found.faults.extend(self.no_json(path)),
        }
    }

    /// The record of a run that was cut is no JSON any more.
    fn no_json(&self, path: &Path) -> Option<Fault> {
        let text = bounded::text(path, bounded::RECORD).ok()?;
        let error = serde_json::from_str::<serde::de::IgnoredAny>(&text).err()?;
        let fix = "restore it from version control, or delete it".to_owned();
        Some(self.fault(&path.with_extension(""), path, format!("it is not JSON: {error}"), fix))
    }

    fn unreadable(&self, path: &Path, error: &RecordError) -> Fault {
        let reason = match error {
            RecordError::Unreadable { source, .. } => source.to_string(),
            RecordError::Malformed { source, .. } => format!("it is not a report's record: {source}"),
            RecordError::Changed { .. } | RecordError::Unsealed { .. } => error.to_string(),
        };
        self.fault(&path.with_extension(""), path, reason, without_record("specforge report SPEC"))
    }
}

/// The name of a report from the path of a file of that name.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A name may have dots, so an ending is appended and never exchanged.
fn markdown(page: &Path) -> PathBuf {
    let mut path = page.as_os_str().to_owned();
    path.push(".md");
    path.into()
}

fn record_of(page: &Path) -> PathBuf {
    let mut path = page.as_os_str().to_owned();
    path.push(".json");
    path.into()
}

/// What to do about a record that is not what it was. A page beside such a record is not written over, so both must go.
fn without_record(again: &str) -> String {
    format!(
        "restore the record from version control, or delete it and its page and render both again: `{again}`"
    )
}
