//! Diagnostics with the texts that they point into.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::Refusal;
use crate::diag::{Diagnostic, Severity, Sources};

/// Diagnostics and the texts that they point into.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The texts.
    pub sources: Sources,
    /// What was found.
    pub diagnostics: Vec<Diagnostic>,
    /// The file that was read: diagnostics without a place are about it.
    pub file: Option<PathBuf>,
}

impl Findings {
    /// What was found in texts.
    pub fn of(sources: Sources, diagnostics: Vec<Diagnostic>) -> Self {
        Self { sources, diagnostics, file: None }
    }

    /// The same of a file.
    pub fn in_file(self, file: &Path) -> Self {
        Self { file: Some(file.to_owned()), ..self }
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|found| found.severity == Severity::Error)
    }
}

/// What was found in several specs or variants so far: a mistake in what they share is one mistake.
#[derive(Clone, Debug, Default)]
pub struct Told(BTreeSet<String>);

impl Told {
    /// Whether a finding is new, which it is once.
    pub fn is_new(&mut self, sources: &Sources, found: &Diagnostic) -> bool {
        let place = found.labels.first().map(|label| sources.place(label.span)).unwrap_or_default();
        self.0.insert(format!("{} {place} {}", found.code, found.message))
    }
}

/// What was found on the way to a plan, in the order in which it was found, each mistake once. Nothing is
/// printed.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// The findings.
    pub findings: Vec<Findings>,
    known: Told,
}

impl Log {
    /// Keeps what is new; `Err` when one of the findings is an error.
    pub fn add(&mut self, mut findings: Findings) -> Result<(), Refusal> {
        let is_refused = findings.has_errors();
        findings.diagnostics.retain(|found| self.known.is_new(&findings.sources, found));
        if !findings.diagnostics.is_empty() {
            self.findings.push(findings);
        }
        if is_refused { Err(Refusal::Invalid) } else { Ok(()) }
    }
}
