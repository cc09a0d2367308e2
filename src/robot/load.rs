//! From the text of a robot file to a robot, with diagnostics that point into the text.

use super::checks::Issue;
use super::file::{self, PARAMS};
use super::model::Robot;
use crate::diag::{Diagnostic, Sink, SourceId, Sources};
use crate::spec::{Marks, decode};

/// Reads a robot file, a text that was added to the sources. `None` when anything is wrong; the
/// diagnostics are in the sink then.
pub fn load(name: &str, sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Robot> {
    let decoded = decode::document(sources, source, PARAMS, sink)?;
    let (robot, issues) = file::from_table(name, &decoded.table);
    for issue in &issues {
        sink.emit(diagnostic(issue, &decoded.marks));
    }
    robot
}

/// An issue as a diagnostic at its place.
fn diagnostic(issue: &Issue, marks: &Marks) -> Diagnostic {
    let error = Diagnostic::error(issue.code, issue.message.clone()).help(issue.help.clone());
    match marks.nearest(&issue.path) {
        Some(mark) => error.at(mark.value, ""),
        None => error,
    }
}

/// A robot that comes with specforge.
pub fn shipped(name: &str) -> Option<Robot> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("robots/{name}.toml"), super::embedded(name)?);
    load(name, &sources, source, &mut sink)
}
