//! The report stage: collects the input, renders, and writes the files to its artefact.

use std::path::Path;

use super::gather::{Law, gather};
use super::{ReportInput, Templates, policies, render};
use crate::diag::{Diagnostic, Sources};
use crate::exec::{Job, Work, WorkError};
use crate::{escape, safe_fs};

/// Renders a report from the artefacts of all arms.
#[derive(Clone, Debug)]
pub struct ReportWork {
    templates: Templates,
    law: Law,
}

impl ReportWork {
    /// A report with these templates; `law` describes a decoded spec's low-level control law.
    pub fn new(templates: Templates, law: Law) -> Self {
        Self { templates, law }
    }
}

impl Work for ReportWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let input = gather(job, self.law)?;
        let mut sources = Sources::default();
        let files = render(&input, &self.templates, &mut sources)
            .map_err(|found| failure(&input, &found, &sources))?;
        for file in files {
            write(job.output, &file.path, file.text.as_bytes())?;
        }
        policies::copies(&input)
            .iter()
            .try_for_each(|copy| write(job.output, Path::new(&copy.file), copy.bytes))
    }
}

/// Writes a file of the report into its artefact. Names of figures and policies contain arm names, which a
/// saved plan may set to anything.
fn write(output: &Path, file: &Path, content: &[u8]) -> Result<(), WorkError> {
    let path =
        safe_fs::inside(output, &file.to_string_lossy()).map_err(|error| WorkError::io(file, error))?;
    let parent = path.parent().unwrap_or(output);
    std::fs::create_dir_all(parent).map_err(|error| WorkError::io(parent, error))?;
    std::fs::write(&path, content).map_err(|error| WorkError::io(&path, error))
}

/// The errors of a template as the failure of a stage: `templates/report.md.j2:12:4: undefined variable`.
fn failure(input: &ReportInput, found: &[Diagnostic], sources: &Sources) -> WorkError {
    let of_template = |diagnostic: &Diagnostic| match diagnostic.labels.is_empty() {
        true => {
            format!("template `{}`: {}", escape::file(Path::new(&input.template)), line(diagnostic, sources))
        }
        false => line(diagnostic, sources),
    };
    let lines: Vec<String> = found.iter().map(of_template).collect();
    let help = found.iter().flat_map(|diagnostic| diagnostic.help.first()).next().cloned();
    WorkError::Failed {
        code: found.first().map(|diagnostic| diagnostic.code),
        message: lines.join("; "),
        help,
    }
}

fn line(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let Some(label) = diagnostic.labels.first() else { return diagnostic.message.clone() };
    let source = sources.get(label.span.source);
    let before = &source.text[..label.span.start];
    let (row, column) =
        (before.matches('\n').count() + 1, before.chars().rev().take_while(|c| *c != '\n').count() + 1);
    format!("{}:{row}:{column}: {}", source.name.display(), diagnostic.message)
}
