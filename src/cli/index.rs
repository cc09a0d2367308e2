//! `specforge report --index`: the overview page `reports/README.md`, from the records next to the reports
//! and from the suite files. Does not need the store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::specs::{self, Findings, Variant};
use super::{Exit, Format, Global, output, overwrite, pages};
use crate::check;
use crate::report::index::{FILE, Index, Listed, Standing, mark};
use crate::report::integrity::{self, Found};
use crate::report::listing;
use crate::report::paths::{self, Paths};
use crate::report::sidecar::Sidecar;
use crate::safe_fs;
use crate::study::standing;

/// The folder that is searched for suites by default.
const SPECS: &str = "specs";

/// Writes the overview page into the folder of the reports.
pub fn run(files: &[PathBuf], folder: &Path, global: &Global) -> Exit {
    let files = match files {
        [] => suites_of(Path::new(SPECS)),
        named => named.to_vec(),
    };
    if files.is_empty() {
        let message = format!("there are no suites below {SPECS}");
        output::complain(global, &message, Some("name the suites, or go to the folder that holds `specs/`"));
        return Exit::Usage;
    }
    let (index, contents) = match read(&files, folder, global) {
        Ok(read) => read,
        Err(exit) => return exit,
    };
    let page = mark::marked(&index.page(), &contents);
    let path = folder.join(FILE);
    let advice = "name the folder of the reports: `--reports DIR`";
    if let Err(exit) = overwrite::allowed(&path, "an index of reports", mark::is_index, advice, global) {
        return exit;
    }
    let written =
        std::fs::create_dir_all(folder).and_then(|()| safe_fs::replace_inside(folder, FILE, page.as_bytes()));
    if let Err(error) = written {
        let message = format!("the page of all reports cannot be written: {}: {error}", path.display());
        output::complain(global, &message, Some("name a folder that can be written with `--reports DIR`"));
        return Exit::StageFailed;
    }
    match global.format {
        Format::Json => {
            let earlier = index.standings.iter().filter(|(_, standing)| **standing != Standing::Current);
            let earlier: Vec<&String> = earlier.map(|(name, _)| name).collect();
            let answer = serde_json::json!({ "index": path.display().to_string(), "earlier": earlier });
            output::data(&answer.to_string());
        }
        _ => output::data(&path.display().to_string()),
    }
    Exit::Ok
}

/// The suites in a folder and its subfolders, sorted.
pub fn suites_of(folder: &Path) -> Vec<PathBuf> {
    let mut suites: Vec<PathBuf> =
        listing::folders(folder).iter().flat_map(|folder| listing::files(folder, "toml")).collect();
    suites.retain(|path| specs::is_suite(path));
    suites.sort();
    suites
}

/// The digests of the records' contents, by the page's path without `.md`.
type Contents = BTreeMap<String, String>;

/// Reads the suites and the reports' records. Reports errors; `Err` is the exit code.
pub fn read(files: &[PathBuf], folder: &Path, global: &Global) -> Result<(Index, Contents), Exit> {
    // Mistakes in the suites are found before all records are read, which takes seconds.
    let suites = files.iter().map(|file| listed(file, global)).collect::<Result<Vec<_>, _>>()?;
    let Found { records, contents, .. } = found(folder, global)?;
    let mut index = Index { suites, reports: records, ..Index::default() };
    index.suites.sort_by(|a, b| a.name.cmp(&b.name));
    index.suites.iter_mut().for_each(|suite| suite.page = page_of(suite, &index.reports));
    for (name, report) in &index.reports {
        if let Some(standing) = standing(report, global)? {
            index.standings.insert(name.clone(), standing);
        }
    }
    Ok((index, contents))
}

/// Whether the runs of a report are those that its command would make today. Warnings of its specs are left
/// to `check` and `run`. Reports errors; `Err` is the exit code.
fn standing(report: &Sidecar, global: &Global) -> Result<Option<Standing>, Exit> {
    let quieter = Global { errors_only: true, ..global.clone() };
    specs::told(|log| standing::of(report, log), &quieter).inspect_err(|_| {
        let advice = "mend the specs, or delete the record and its page";
        let message = format!("the report {} was made by `{}`, which fails", report.report, report.command());
        output::complain(global, &message, Some(advice));
    })
}

fn listed(file: &Path, global: &Global) -> Result<Listed, Exit> {
    if !specs::is_suite(file) {
        let message = format!("{} is not a suite", file.display());
        output::complain(
            global,
            &message,
            Some("name suites only: reports of single specs are listed by themselves"),
        );
        return Err(Exit::Usage);
    }
    let checked = check::suite(file, &Variant::default().options());
    // Warnings are reported when the suite is checked or run.
    if checked.sink.has_errors() {
        specs::tell(&[Findings::of(checked.sources, checked.sink.diagnostics)], global);
        return Err(Exit::Invalid);
    }
    let suite = checked.suite.ok_or(Exit::Invalid)?;
    let file = Paths::of(file).shown(&file.display().to_string());
    let page = paths::page_folder(&file).join(&suite.name).display().to_string();
    let claims = checked.claims;
    Ok(Listed { name: suite.name, page, summary: suite.summary, file, profiles: suite.profiles, claims })
}

/// The path of a suite's page: its own, or that of an older report of the same suite that was written
/// directly into the folder.
fn page_of(suite: &Listed, reports: &BTreeMap<String, Sidecar>) -> String {
    let is_of_suite = |report: &Sidecar| report.request.files == [suite.file.as_str()];
    match reports.get(&suite.name) {
        Some(report) if !reports.contains_key(&suite.page) && is_of_suite(report) => suite.name.clone(),
        _ => suite.page.clone(),
    }
}

/// The records of a folder. Returns an error if any file was changed after it was published.
fn found(folder: &Path, global: &Global) -> Result<Found, Exit> {
    let found = integrity::verify(folder);
    if !found.faults.is_empty() {
        found.faults.iter().for_each(|fault| pages::tell(fault, folder, global));
        return Err(Exit::StageFailed);
    }
    Ok(found)
}
