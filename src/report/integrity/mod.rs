//! Verifies a folder of published reports: each record against its own digest, page, figures, name, place and
//! verdicts; the index; and specforge files that no record lists.

mod index;
mod record;
mod stray;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub use self::stray::is_figure;
use super::index::mark;
use super::listing;
use super::render_command::UNKNOWN;
use super::sidecar::{RecordError, Sidecar};
use crate::bounded;
use crate::escape::shell;
use crate::exec::records;

/// A file that was changed after publication.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The path of the report's page in the folder of reports, without `.md`.
    pub report: String,
    /// The path of the file in that folder.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
    /// How to fix it.
    pub fix: String,
}

/// The result for a folder of reports.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// The readable records, by page path without `.md`.
    pub records: BTreeMap<String, Sidecar>,
    /// The digests of their contents, by the same path.
    pub contents: BTreeMap<String, String>,
    /// How to render them again, by the same path: the command of the run, for records that were edited only
    /// what it consists of.
    pub commands: BTreeMap<String, String>,
    /// Number of unchanged records of runs.
    pub runs: usize,
    /// Their paths in the folder of reports, by file name and content.
    run_paths: BTreeMap<RunFile, String>,
    /// Files that were changed after publication.
    pub faults: Vec<Fault>,
    /// An index that was edited, which the next `specforge report --index` writes again.
    pub unwritten: Vec<Fault>,
    /// Unchanged records that were judged by other rules than this version's, and an unchanged index that was
    /// written before today's records.
    pub out_of_date: Vec<Fault>,
}

/// The file of a record of a run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct RunFile {
    /// Its name without the folder.
    name: String,
    /// BLAKE3 of its bytes.
    content: String,
}

impl Found {
    /// The reports with a fault, or that `--index` would change.
    pub fn differing(&self) -> BTreeSet<&str> {
        self.faults.iter().chain(&self.unwritten).map(|fault| fault.report.as_str()).collect()
    }

    /// The reports that match all their digests.
    pub fn whole(&self) -> Vec<&str> {
        let differing = self.differing();
        self.records.keys().map(String::as_str).filter(|name| !differing.contains(name)).collect()
    }
}

/// Verifies every record in a folder and its subfolders against its files. A missing folder has no records.
pub fn verify(folder: &Path) -> Found {
    let mut found = Found::default();
    // The files listed by records, as paths from the folder of reports.
    let mut listed = BTreeSet::new();
    let folders = listing::folders(folder);
    for below in &folders {
        let place = Place { folder, below };
        let records = listing::files(below, "json");
        let has_pages = *below == folder || records.iter().any(|path| path.with_extension("md").is_file());
        for path in &records {
            match Sidecar::open(path) {
                Ok((record, seal)) => place.record(record, seal, path, &mut found, &mut listed),
                Err(error) => place.other(path, &error, has_pages, &mut found),
            }
        }
        place.pages_without_record(&mut found);
        place.figures_without_report(&mut found);
    }
    stray::copies(&mut found);
    for below in &folders {
        let place = Place { folder, below };
        place.unlisted_figures(&listed, &mut found);
        place.unlisted_policies(&listed, &mut found);
        place.index(&mut found);
    }
    found
}

/// A folder of pages.
struct Place<'a> {
    /// The folder of all reports.
    folder: &'a Path,
    /// The folder itself or one of its subfolders.
    below: &'a Path,
}

impl Place<'_> {
    /// Converts a path to one relative to the folder of all reports.
    fn seen(&self, path: &Path) -> String {
        path.strip_prefix(self.folder).unwrap_or(path).display().to_string()
    }

    /// The command that writes the index of the folder of all reports.
    fn index_command(&self) -> String {
        match self.folder == Path::new("reports") {
            true => "specforge report --index".to_owned(),
            false => format!("specforge report --index --reports {}", shell::argument(self.folder)),
        }
    }

    fn fault(&self, page: &Path, file: &Path, reason: impl Into<String>, fix: String) -> Fault {
        Fault { report: self.seen(page), file: self.seen(file), reason: reason.into(), fix }
    }

    /// Handles a JSON file that is not a report's record: a run's, or another in a folder without pages.
    fn other(&self, path: &Path, error: &RecordError, has_pages: bool, found: &mut Found) {
        match records::verify(path) {
            Some(Ok(())) => self.run(path, found),
            Some(Err(reason)) => {
                let fix = "restore it from version control, or write it again: delete it and \
                           `specforge cache export SPEC --to DIR`";
                found.faults.push(self.fault(&path.with_extension(""), path, reason, fix.to_owned()));
            }
            None if has_pages => found.faults.push(self.unreadable(path, error)),
            None => found.faults.extend(self.no_json(path)),
        }
    }

    /// Counts an unchanged record of a run, unless it is a copy of another one.
    fn run(&self, path: &Path, found: &mut Found) {
        let bytes = bounded::bytes(path, bounded::RECORD).unwrap_or_default();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let file = RunFile { name, content: blake3::hash(&bytes).to_hex().to_string() };
        match found.run_paths.get(&file) {
            None => {
                found.run_paths.insert(file, self.seen(path));
                found.runs += 1;
            }
            Some(other) => {
                let reason = format!("it is the same record of a run as `{other}`: one of them is a copy");
                let fix = "delete the copy".to_owned();
                found.faults.push(self.fault(&path.with_extension(""), path, reason, fix));
            }
        }
    }

    /// The fault of a truncated record of a run, which is no longer valid JSON.
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
        self.fault(&path.with_extension(""), path, reason, without_record(UNKNOWN))
    }
}

/// The name of a report, from the path of one of its files.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Appends the extension instead of replacing one, as a name may contain dots.
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

/// The fix for a changed record. Its page blocks a new one, so both must be deleted.
fn without_record(again: &str) -> String {
    format!(
        "restore the record from version control, or delete it and its page and render both again: {again}"
    )
}
