//! Whether a folder of reports is as it was published: every record with its own digest, its page, its
//! figures and its name, and no page or figure of ours without a record. What lacks a digest is told apart
//! from what agrees with one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::index::FILE;
use super::seal::Seal;
use super::sidecar::{RecordError, Sidecar};
use super::{digests, earlier, listing};
use crate::bounded;
use crate::escape::xml;

/// A sentence that the shipped templates write at the end of a page.
const RENDERED: &str = "Rendered by specforge ";

/// What they write above the table of stages.
const STAGES: &str = "<summary>Stages and their fingerprints</summary>";

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
    /// Files that are not as they were published.
    pub faults: Vec<Fault>,
    /// Pages that lack the notice of earlier rules, which `specforge report --index` writes.
    pub unmarked: Vec<Fault>,
    /// Reports without a fault that have no digests to agree with.
    pub unverifiable: Vec<Unverifiable>,
}

impl Found {
    /// The reports with a fault, those that lack their notice among them.
    pub fn differing(&self) -> BTreeSet<&str> {
        self.faults.iter().chain(&self.unmarked).map(|fault| fault.report.as_str()).collect()
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

/// Reads every record in a folder and below it and holds it against its files. A folder that is not there has
/// none.
pub fn verify(folder: &Path) -> Found {
    let mut found = Found::default();
    for below in listing::folders(folder) {
        let place = Place { folder, below: &below };
        let records = listing::files(&below, "json");
        // Other JSON files, such as the records of runs, lie in folders without a page.
        let has_pages = below == folder || records.iter().any(|path| path.with_extension("md").is_file());
        for path in &records {
            match Sidecar::open(path) {
                Ok((record, seal)) if has_pages || record.report == stem(path) => {
                    place.record(record, seal, path, &mut found)
                }
                Err(error) if has_pages => found.faults.push(place.unreadable(path, &error)),
                Ok(_) | Err(_) => {}
            }
        }
        place.pages_without_record(&mut found);
        place.figures_without_report(&mut found);
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
}

impl Place<'_> {
    /// A path of this place as seen from the folder of all reports.
    fn seen(&self, path: &Path) -> String {
        path.strip_prefix(self.folder).unwrap_or(path).display().to_string()
    }

    fn fault(&self, page: &Path, file: &Path, reason: impl Into<String>, fix: String) -> Fault {
        Fault { report: self.seen(page), file: self.seen(file), reason: reason.into(), fix }
    }

    fn unreadable(&self, path: &Path, error: &RecordError) -> Fault {
        let reason = match error {
            RecordError::Unreadable { source, .. } => source.to_string(),
            RecordError::Malformed { source, .. } => format!("it is not a report's record: {source}"),
            RecordError::Changed { .. } => error.to_string(),
        };
        self.fault(&path.with_extension(""), path, reason, without_record("specforge report SPEC"))
    }

    /// Holds a record against its name, its digest, its page and its figures.
    fn record(&self, record: Sidecar, seal: Seal, path: &Path, found: &mut Found) {
        let page = path.with_extension("");
        let name = stem(path);
        if record.report != name {
            let reason = format!("it is the record of another page, `{}`", record.report);
            found.faults.push(self.fault(&page, path, reason, without_record("specforge report SPEC")));
        }
        match seal {
            Seal::Whole => {}
            Seal::Broken => {
                let reason = "it was changed after it was written: it does not have its own digest";
                found.faults.push(self.fault(&page, path, reason, without_record("specforge report SPEC")));
            }
            Seal::Absent => {
                let reason = match record.digests.is_empty() {
                    true => "the record has no digests of itself, the page and the figures",
                    false => "the record has no digest of itself",
                };
                found.unverifiable.push(Unverifiable { report: self.seen(&page), reason });
            }
        }
        let again = match seal {
            Seal::Broken => "specforge report SPEC".to_owned(),
            Seal::Whole | Seal::Absent => record.command.replacen("specforge run ", "specforge report ", 1),
        };
        let fix = format!("restore it from version control, or render it again: `{again}`");
        for difference in digests::differences(self.below, &record.digests) {
            let file = self.below.join(&difference.file);
            found.faults.push(self.fault(&page, &file, difference.reason, fix.clone()));
        }
        // Files that no digest speaks of must be there all the same.
        let figures = record.items.iter().map(|item| item.file.clone()).filter(|file| !file.is_empty());
        let files: BTreeSet<String> = figures.chain([format!("{name}.md")]).collect();
        for file in files.into_iter().filter(|file| !record.digests.contains_key(file)) {
            let file = self.below.join(file);
            if !file.is_file() {
                found.faults.push(self.fault(
                    &page,
                    &file,
                    "it is missing, and its record is there",
                    fix.clone(),
                ));
            }
        }
        self.notice(&record, &page, &fix, found);
        found.records.insert(self.seen(&page), record);
    }

    /// The notice of earlier rules stands on the pages that were judged by them and on no other.
    fn notice(&self, record: &Sidecar, page: &Path, fix: &str, found: &mut Found) {
        let file = markdown(page);
        let Ok(text) = bounded::text(&file, bounded::RECORD) else { return };
        match (record.is_by_earlier_rules(), text.lines().any(|line| line == earlier::NOTICE)) {
            (true, false) => {
                let reason = "it does not say that it was judged by earlier rules";
                let fix = "`specforge report --index` writes that sentence below its title".to_owned();
                found.unmarked.push(self.fault(page, &file, reason, fix));
            }
            (false, true) => {
                let reason = "it says that it was judged by earlier rules, and its record does not";
                found.faults.push(self.fault(page, &file, reason, fix.to_owned()));
            }
            (true, true) | (false, false) => {}
        }
    }

    /// Pages of ours whose record is not there. Other Markdown is nobody's business.
    fn pages_without_record(&self, found: &mut Found) {
        for path in listing::files(self.below, "md") {
            let page = path.with_extension("");
            let is_index = path.file_name().is_some_and(|name| name.eq_ignore_ascii_case(FILE));
            if is_index || record_of(&page).symlink_metadata().is_ok() {
                continue;
            }
            let text = bounded::text(&path, bounded::RECORD).unwrap_or_default();
            let is_ours = [RENDERED, STAGES, earlier::NOTICE].iter().any(|mark| text.contains(mark));
            if is_ours || self.figures_of(&page).next().is_some() {
                let reason = "it is the page of a report, and its record is missing";
                found.faults.push(self.fault(&page, &path, reason, without_record("specforge report SPEC")));
            }
        }
    }

    /// Figures of ours whose page and record are not there.
    fn figures_without_report(&self, found: &mut Found) {
        let has = |file: PathBuf| file.symlink_metadata().is_ok();
        if self.below == self.folder || has(markdown(self.below)) || has(record_of(self.below)) {
            return;
        }
        for file in self.figures_of(self.below) {
            let reason = "it is the figure of a report, and page and record are missing";
            let fix = "restore them from version control, render them again with `specforge report SPEC`, or \
                delete it";
            found.faults.push(self.fault(self.below, &file, reason, fix.to_owned()));
        }
    }

    /// The figures in a page's folder that say that they are its own.
    fn figures_of<'p>(&self, page: &'p Path) -> impl Iterator<Item = PathBuf> + use<'p> {
        let name = serde_json::Value::from(stem(&markdown(page))).to_string();
        let mark = format!("<metadata>{{\"report\":{}", xml::text(&name));
        let is_own =
            move |path: &PathBuf| bounded::text(path, bounded::RECORD).is_ok_and(|text| text.contains(&mark));
        listing::files(page, "svg").into_iter().filter(is_own)
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

/// What to do about a record that is not what it was. A page beside such a record is not written over, so
/// both must go.
fn without_record(again: &str) -> String {
    format!(
        "restore the record from version control, or delete it and its page and render both again: `{again}`"
    )
}
