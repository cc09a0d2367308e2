//! Loads a robot from the text of its file, with diagnostics that point into the text.

use super::checks::Issue;
use super::file::{self, PARAMS};
use super::model::Robot;
use crate::diag::{Diagnostic, Sink, SourceId, Sources};
use crate::spec::{Marks, decode};

/// Reads a robot file in the sources. `None` if it has errors; all diagnostics are then in the sink.
pub fn load(name: &str, sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Robot> {
    let mut own = Sink::default();
    let robot = read(name, sources, source, &mut own).filter(|_| !own.has_errors());
    sink.diagnostics.append(&mut own.diagnostics);
    robot
}

/// The same, but also returns a robot whose model is valid and whose checks find errors.
pub fn read(name: &str, sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Robot> {
    let decoded = decode::document(sources, source, PARAMS, sink)?;
    let (robot, issues) = file::from_table(name, &decoded.table);
    for issue in &issues {
        sink.emit(diagnostic(issue, &decoded.marks));
    }
    robot
}

/// An issue as a diagnostic at its place in the robot's file.
pub fn diagnostic(issue: &Issue, marks: &Marks) -> Diagnostic {
    let found =
        Diagnostic { severity: issue.severity(), ..Diagnostic::error(issue.code, issue.message.as_str()) };
    let found = match marks.nearest(&issue.path) {
        Some(mark) => found.at(mark.value, ""),
        None => found,
    };
    if issue.help.is_empty() { found } else { found.help(issue.help.as_str()) }
}

/// All errors and warnings for the text of a robot's file, as shown by `robot show`. Those of the text itself
/// have its line as path.
pub fn issues(name: &str, text: &str) -> Vec<Issue> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("{name}.toml"), text);
    let decoded = decode::document(&sources, source, PARAMS, &mut sink);
    let mut issues: Vec<Issue> = sink.diagnostics.iter().map(|told| of_text(told, &sources)).collect();
    issues.extend(decoded.into_iter().flat_map(|decoded| file::from_table(name, &decoded.table).1));
    issues
}

/// Converts a diagnostic of a robot's text to an issue.
fn of_text(told: &Diagnostic, sources: &Sources) -> Issue {
    let line = told.labels.first().map(|label| sources.positions(label.span)[0].line);
    Issue {
        code: told.code,
        path: line.map_or_else(String::new, |line| format!("line {line}")),
        message: told.message.clone(),
        help: told.help.join("; "),
    }
}

/// A robot embedded in specforge.
pub fn shipped(name: &str) -> Option<Robot> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("robots/{name}.toml"), super::embedded(name)?);
    load(name, &sources, source, &mut sink)
}
