//! `specforge report --check`: whether the records, pages and figures in a folder of reports are unchanged
//! since they were published. Does not need the store.

use std::path::Path;

use serde_json::json;

use super::{Exit, Format, Global, output};
use crate::report::integrity::{self, Fault, Found, Unverifiable};

/// The diagnostic's code.
pub const CODE: &str = "R0013";

/// Compares every record with its digest, values, page and figures, and the index with all records.
pub fn check(folder: &Path, global: &Global) -> Exit {
    if !folder.is_dir() {
        let message = format!("{} is not a folder", folder.display());
        output::complain(global, &message, Some("name the folder of the reports: `--reports DIR`"));
        return Exit::Usage;
    }
    let found = integrity::verify(folder);
    let (whole, differing) = (found.whole().len(), found.differing().len());
    let faults = || found.faults.iter().chain(&found.unwritten);
    if global.format == Format::Json {
        let faults = faults().map(|Fault { report, file, reason, fix }| {
            json!({ "code": CODE, "report": report, "file": file, "reason": reason, "help": fix })
        });
        let unverifiable = found.unverifiable.iter();
        let unverifiable =
            unverifiable.map(|Unverifiable { report, reason }| json!({ "report": report, "reason": reason }));
        output::json(&json!({
            "whole": whole,
            "differing": faults.collect::<Vec<_>>(),
            "unverifiable": unverifiable.collect::<Vec<_>>(),
            "runs": found.runs,
        }));
    } else {
        faults().for_each(|fault| tell(fault, folder, global));
        output::note(
            global,
            &format!("reports unchanged since they were rendered: {whole}; changed: {differing}"),
        );
        output::note(global, &unverifiable(&found).unwrap_or_default());
        if found.runs > 0 {
            output::note(global, &format!("records of runs that are as they were written: {}", found.runs));
        }
    }
    if differing == 0 { Exit::Ok } else { Exit::StageFailed }
}

/// Reports a file that was changed after it was published, with the fix.
pub fn tell(fault: &Fault, folder: &Path, global: &Global) {
    let message = format!("{}: {}", folder.join(&fault.file).display(), fault.reason);
    output::fault(global, Some(CODE), &message, Some(&fault.fix));
}

/// The reports that cannot be verified, grouped by reason; `None` if all can.
pub fn unverifiable(found: &Found) -> Option<String> {
    let mut reasons: Vec<&str> = found.unverifiable.iter().map(|unverifiable| unverifiable.reason).collect();
    reasons.sort_unstable();
    reasons.dedup();
    let of = |reason: &str| {
        let those = found.unverifiable.iter().filter(|unverifiable| unverifiable.reason == reason);
        let names: Vec<&str> = those.map(|unverifiable| unverifiable.report.as_str()).collect();
        format!("reports that cannot be verified, because {reason}: {} ({})", names.join(", "), names.len())
    };
    let lines: Vec<String> = reasons.into_iter().map(of).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}
