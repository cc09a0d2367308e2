//! From the text of a robot file to a robot, with diagnostics that point into the text.

use super::checks::Issue;
use super::file::{self, PARAMS};
use super::model::Robot;
use crate::diag::{Diagnostic, Sink, SourceId, Sources};
use crate::spec::{Marks, decode};

/// Reads a robot file, a text that was added to the sources. `None` if it has errors; everything that was
/// found is in the sink then.
pub fn load(name: &str, sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Robot> {
    let mut own = Sink::default();
    let robot = read(name, sources, source, &mut own).filter(|_| !own.has_errors());
    sink.diagnostics.append(&mut own.diagnostics);
    robot
}

/// The same, with the robot also if its model is sound and its checks find errors.
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

/// Everything that is wrong with the text of a robot's file, or suspicious in it, as `robot show` tells it.
/// What is wrong with the text itself has its line as its path.
pub fn issues(name: &str, text: &str) -> Vec<Issue> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("{name}.toml"), text);
    let decoded = decode::document(&sources, source, PARAMS, &mut sink);
    let mut issues: Vec<Issue> = sink.diagnostics.iter().map(|told| of_text(told, &sources)).collect();
    issues.extend(decoded.into_iter().flat_map(|decoded| file::from_table(name, &decoded.table).1));
    issues
}

/// A diagnostic of a robot's text as an issue.
fn of_text(told: &Diagnostic, sources: &Sources) -> Issue {
    let line = told.labels.first().map(|label| sources.positions(label.span)[0].line);
    Issue {
        code: told.code,
        path: line.map_or_else(String::new, |line| format!("line {line}")),
        message: told.message.clone(),
        help: told.help.join("; "),
    }
}

/// A robot that comes with specforge.
pub fn shipped(name: &str) -> Option<Robot> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("robots/{name}.toml"), super::embedded(name)?);
    load(name, &sources, source, &mut sink)
}
