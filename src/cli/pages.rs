//! `specforge report --check`: whether the pages and figures in a folder of reports are as they were rendered. Needs no store.

use std::path::Path;

use serde_json::json;

use super::{Exit, Format, Global, index, output};
use crate::report::digests::{self, Difference};

/// The diagnostic's code.
const CODE: &str = "R0013";

/// A report with files that are not as they were rendered.
struct Differing<'a> {
    /// The path of its page in the folder of the reports, without `.md`.
    page: &'a str,
    command: &'a str,
    /// The files, by their paths in the folder of the reports.
    files: Vec<Difference>,
}

/// Holds every page that has a record against the record's digests.
pub fn check(folder: &Path, global: &Global) -> Exit {
    if !folder.is_dir() {
        let message = format!("{} is not a folder", folder.display());
        output::complain(global, &message, Some("name the folder of the reports: `--reports DIR`"));
        return Exit::Usage;
    }
    let records = match index::records(folder, global) {
        Ok(records) => records,
        Err(exit) => return exit,
    };
    let (checkable, unchecked): (Vec<_>, Vec<_>) = records.iter().partition(|(_, record)| !record.digests.is_empty());
    let differing: Vec<Differing> = checkable
        .iter()
        .map(|(page, record)| {
            // Digests name files from the folder of the page.
            let own = Path::new(page).parent().unwrap_or(Path::new(""));
            let mut files = digests::differences(&folder.join(own), &record.digests);
            files.iter_mut().for_each(|found| found.file = own.join(&found.file).display().to_string());
            Differing { page, command: &record.command, files }
        })
        .filter(|differing| !differing.files.is_empty())
        .collect();
    let unchecked: Vec<&String> = unchecked.into_iter().map(|(name, _)| name).collect();
    let whole = checkable.len() - differing.len();
    if global.format == Format::Json {
        let faults = differing.iter().flat_map(|Differing { page, files, .. }| {
            let fault = move |found: &Difference| {
                json!({ "code": CODE, "report": page, "file": found.file, "reason": found.reason })
            };
            files.iter().map(fault)
        });
        output::json(&json!({ "whole": whole, "differing": faults.collect::<Vec<_>>(), "unchecked": unchecked }));
    } else {
        for Differing { command, files, .. } in &differing {
            for Difference { file, reason } in files {
                let help = format!("take it from version control, or render it again: `{command}`");
                output::fault(global, Some(CODE), &format!("{}: {reason}", folder.join(file).display()), Some(&help));
            }
        }
        let counts = format!("{whole} reports are as they were rendered, {} are not", differing.len());
        let rest = match unchecked.len() {
            0 => String::new(),
            count => format!("; {count} cannot be checked: their records have no digests"),
        };
        output::note(global, &(counts + &rest));
    }
    if differing.is_empty() { Exit::Ok } else { Exit::StageFailed }
}
