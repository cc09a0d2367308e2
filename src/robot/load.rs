//! From the text of a robot file to a robot, with diagnostics that point into the text.

use super::checks::Issue;
use super::file::{self, PARAMS};
use super::model::Robot;
use crate::diag::{Diagnostic, Sink, Sources};
use crate::spec::{Marks, decode};

/// Reads a robot file: `name` is the robot's name, `place` names the file in messages. `None` when
/// anything is wrong; the diagnostics are in the sink then.
pub fn load(name: &str, place: &str, text: &str, output: (&mut Sources, &mut Sink)) -> Option<Robot> {
    let (sources, sink) = output;
    let decoded = decode::document(place, text, PARAMS, (sources, &mut *sink))?;
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
    load(name, &format!("robots/{name}.toml"), super::embedded(name)?, (&mut sources, &mut sink))
}
