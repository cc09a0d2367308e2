//! `specforge report --check`: whether the records, pages and figures in a folder of reports are unchanged
//! since they were published, and whether their specs still are. Does not need the store.

use std::path::Path;

use serde_json::json;

use super::{Exit, Format, Global, output};
use crate::report::integrity::{self, Fault, Found};
use crate::report::sidecar::Sidecar;
use crate::study::out_of_date::{self, OutOfDate};

/// The diagnostic's code.
pub const CODE: &str = "R0013";

/// Compares every record with its digest, values, page and figures, the index with all records, and each page
/// with its specs as they are now.
pub fn check(folder: &Path, global: &Global) -> Exit {
    if !folder.is_dir() {
        let message = format!("{} is not a folder", folder.display());
        output::complain(global, &message, Some("name the folder of the reports: `--reports DIR`"));
        return Exit::Usage;
    }
    let found = integrity::verify(folder);
    let (whole, differing) = (found.whole().len(), found.differing().len());
    let faults = || found.faults.iter().chain(&found.unwritten);
    let earlier = earlier(&found, folder);
    if global.format == Format::Json {
        let faults = faults().map(|fault| {
            let mut document = document(fault);
            document["code"] = CODE.into();
            document
        });
        output::json(&json!({
            "whole": whole,
            "differing": faults.collect::<Vec<_>>(),
            "out_of_date": found.out_of_date.iter().chain(&earlier).map(document).collect::<Vec<_>>(),
            "runs": found.runs,
        }));
    } else {
        faults().for_each(|fault| tell(fault, folder, global));
        for fault in &found.out_of_date {
            let message = format!("{}: {}", folder.join(&fault.file).display(), fault.reason);
            output::complain(global, &message, Some(&fault.fix));
        }
        for Fault { file, reason, fix, .. } in &earlier {
            let file = folder.join(file);
            output::note(global, &format!("warning: {}: {reason}; {fix}", file.display()));
        }
        let older = match found.out_of_date.len() + earlier.len() {
            0 => String::new(),
            some => format!("; out of date: {some}"),
        };
        output::note(
            global,
            &format!("reports unchanged since they were rendered: {whole}; changed: {differing}{older}"),
        );
        if found.runs > 0 {
            output::note(global, &format!("records of runs that are as they were written: {}", found.runs));
        }
    }
    if differing == 0 && found.out_of_date.is_empty() { Exit::Ok } else { Exit::StageFailed }
}

/// The pages whose specs differ now or are gone. The pages themselves are unchanged, so this is a warning.
fn earlier(found: &Found, folder: &Path) -> Vec<Fault> {
    let of = |(page, record): (&String, &Sidecar)| {
        let below = folder.join(Path::new(page).parent().unwrap_or(Path::new("")));
        let OutOfDate { reason, fix } = out_of_date::find(record, &below)?;
        Some(Fault { report: page.clone(), file: format!("{page}.md"), reason, fix })
    };
    found.records.iter().filter_map(of).collect()
}

fn document(fault: &Fault) -> serde_json::Value {
    let Fault { report, file, reason, fix } = fault;
    json!({ "report": report, "file": file, "reason": reason, "help": fix })
}

/// Reports a file that was changed after it was published, with the fix.
pub fn tell(fault: &Fault, folder: &Path, global: &Global) {
    let message = format!("{}: {}", folder.join(&fault.file).display(), fault.reason);
    output::fault(global, Some(CODE), &message, Some(&fault.fix));
}
