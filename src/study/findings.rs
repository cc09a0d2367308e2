//! Diagnostics with the sources that they point into.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::Refusal;
use crate::diag::{Diagnostic, Severity, Sources};

/// Diagnostics and the sources that they point into.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The sources.
    pub sources: Sources,
    /// The diagnostics.
    pub diagnostics: Vec<Diagnostic>,
    /// The file that was read, for diagnostics without a location.
    pub file: Option<PathBuf>,
}

impl Findings {
    /// Diagnostics in these sources.
    pub fn of(sources: Sources, diagnostics: Vec<Diagnostic>) -> Self {
        Self { sources, diagnostics, file: None }
    }

    /// The same for this file.
    pub fn in_file(self, file: &Path) -> Self {
        Self { file: Some(file.to_owned()), ..self }
    }

    /// Whether any of them is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|found| found.severity == Severity::Error)
    }
}

/// The diagnostics of several specs or variants so far: an error in a shared part is reported once.
#[derive(Clone, Debug, Default)]
pub struct Told(BTreeSet<String>);

impl Told {
    /// Whether a diagnostic is new; it counts as known from then on.
    pub fn is_new(&mut self, sources: &Sources, found: &Diagnostic) -> bool {
        let place = found.labels.first().map(|label| sources.place(label.span)).unwrap_or_default();
        self.0.insert(format!("{} {place} {}", found.code, found.message))
    }
}

/// Diagnostics on the way to a plan, in order, each once. Nothing is printed.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// The diagnostics.
    pub findings: Vec<Findings>,
    /// What is worth knowing about a valid study, a sentence each.
    pub notes: Vec<String>,
    known: Told,
}

impl Log {
    /// Adds new diagnostics; `Err` if any of the findings is an error.
    pub fn add(&mut self, mut findings: Findings) -> Result<(), Refusal> {
        let is_refused = findings.has_errors();
        findings.diagnostics.retain(|found| self.known.is_new(&findings.sources, found));
        if !findings.diagnostics.is_empty() {
            self.findings.push(findings);
        }
        if is_refused { Err(Refusal::Invalid) } else { Ok(()) }
    }
}
