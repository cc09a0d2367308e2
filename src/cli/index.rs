//! `specforge report --index`: the page of pages, `reports/README.md`, from the records beside the reports and the suites'
//! files. Needs no store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::specs::{self, Findings, Variant};
use super::{Exit, Format, Global, output, standing};
use crate::bounded;
use crate::check;
use crate::report::earlier;
use crate::report::index::{FILE, Index, Listed, Standing};
use crate::report::paths::Paths;
use crate::report::sidecar::Sidecar;
use crate::safe_fs;

/// Where the suites are when none are named.
const SUITES: &str = "specs/suites";

/// Writes the page into the folder of the reports.
pub fn run(files: &[PathBuf], folder: &Path, global: &Global) -> Exit {
    let files = match files {
        [] => suites_of(Path::new(SUITES)),
        named => named.to_vec(),
    };
    if files.is_empty() {
        let message = format!("there are no suites in {SUITES}");
        output::complain(global, &message, Some("name the suites, or go to the folder that holds `specs/`"));
        return Exit::Usage;
    }
    let index = match read(&files, folder, global) {
        Ok(index) => index,
        Err(exit) => return exit,
    };
    let path = folder.join(FILE);
    let written =
        std::fs::create_dir_all(folder).and_then(|()| safe_fs::replace_inside(folder, FILE, index.page().as_bytes()));
    if let Err(error) = written {
        let message = format!("the page of all reports cannot be written: {}: {error}", path.display());
        output::complain(global, &message, Some("name a folder that can be written with `--reports DIR`"));
        return Exit::StageFailed;
    }
    if let Err(error) = mark(&index, folder) {
        let message = format!("a page of {} cannot be written: {error}", folder.display());
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

/// Writes the notice into the pages that were judged by earlier rules.
fn mark(index: &Index, folder: &Path) -> std::io::Result<()> {
    for (name, _) in index.reports.iter().filter(|(_, report)| report.is_by_earlier_rules()) {
        let file = format!("{name}.md");
        let text = match bounded::text(&folder.join(&file), bounded::RECORD) {
            Ok(text) => text,
            Err(error) if error.is_absence() => continue,
            Err(error) => return Err(error.into()),
        };
        if let Some(marked) = earlier::marked(&text) {
            safe_fs::replace_inside(folder, &file, marked.as_bytes())?;
        }
    }
    Ok(())
}

/// The suites in a folder, sorted.
pub fn suites_of(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut suites: Vec<PathBuf> = entries.filter(|path| specs::is_suite(path)).collect();
    suites.sort();
    suites
}

/// Reads the suites and the records of the reports. `Err` is the exit code; everything has been said then.
pub fn read(files: &[PathBuf], folder: &Path, global: &Global) -> Result<Index, Exit> {
    let mut index = Index::default();
    for file in files {
        index.suites.push(listed(file, global)?);
    }
    index.suites.sort_by(|a, b| a.name.cmp(&b.name));
    index.reports = records(folder, global)?;
    for (name, report) in &index.reports {
        if let Some(standing) = standing::of(report, global)? {
            index.standings.insert(name.clone(), standing);
        }
    }
    Ok(index)
}

fn listed(file: &Path, global: &Global) -> Result<Listed, Exit> {
    if !specs::is_suite(file) {
        let message = format!("{} is not a suite", file.display());
        output::complain(global, &message, Some("the index lists suites; single specs have a page of their own"));
        return Err(Exit::Usage);
    }
    let checked = check::suite(file, &Variant::default().options());
    // What is only suspicious is told when the suite is checked or run.
    if checked.sink.has_errors() {
        specs::tell(&[Findings::of(checked.sources, checked.sink.diagnostics)], global);
        return Err(Exit::Invalid);
    }
    let suite = checked.suite.ok_or(Exit::Invalid)?;
    let file = Paths::of(file).shown(&file.display().to_string());
    Ok(Listed { name: suite.name, summary: suite.summary, file, claims: checked.claims })
}

/// The records in a folder by the name of their report; a folder that is not there has none.
pub fn records(folder: &Path, global: &Global) -> Result<BTreeMap<String, Sidecar>, Exit> {
    let mut records = BTreeMap::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in entries.filter(|path| path.extension().is_some_and(|ending| ending == "json")) {
        match Sidecar::read(&path) {
            Ok(record) => {
                records.insert(record.report.clone(), record);
            }
            Err(error) => {
                let advice = "render the report again, or take the file away";
                output::complain(global, &error.to_string(), Some(advice));
                return Err(Exit::Usage);
            }
        }
    }
    Ok(records)
}
