//! A file of a report.

use std::path::PathBuf;

/// A file of a report, its path relative to the reports' folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportFile {
    /// `NAME.md`, `NAME.json`, `NAME/FIGURE.svg`.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}
