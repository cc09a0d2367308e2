//! Protects an existing page: an incomplete report does not replace one with more results, or one whose
//! number of results is unknown.

use std::path::Path;

use crate::report::sidecar::Sidecar;

/// Why an incomplete report with `results` results must not replace the page of a record, and the fix;
/// `again` says how to restore the missing results.
pub fn objection(record: &Path, results: usize, again: &str) -> Option<(String, String)> {
    let page = record.with_extension("md");
    let page = page.display();
    match Sidecar::read(record) {
        Ok(known) if known.results() > results => {
            let message =
                format!("{page} has {} results, and this report would have {results}", known.results());
            Some((message, format!("{again}; `--reports DIR` writes this report beside the other")))
        }
        Err(error) if !error.is_absence() => {
            let message =
                format!("{error}; {page} may have more results than this report, which would have {results}");
            let advice = "restore the record from version control, or delete it and its page";
            Some((message, format!("{advice}; `--reports DIR` writes this report beside the other")))
        }
        Ok(_) | Err(_) => None,
    }
}
