//! The files that a spec names: its robot and its reference motion.

use std::sync::Arc;

use super::issue;
use super::once::Once;
use crate::diag::{Diagnostic, Severity, Sink, Sources};
use crate::kinds::motion;
use crate::kinds::motion::clip::Clip;
use crate::robot::{self, Robot};
use crate::spec::decode::{self, Decoded};
use crate::spec::{Attachment, Experiment, Reach, Section, Table, Value, section};
use crate::syntax::{self, Files};

/// The name and the text of a file.
pub type File = (String, Arc<str>);

/// The robots read so far; `None` for a file with findings.
#[derive(Clone, Debug, Default)]
pub struct Robots {
    known: Once<File, Option<Robot>>,
}

impl Robots {
    /// The robot of a file, cached or read now.
    pub fn read(
        &self,
        file: &Attachment,
        experiment: &Experiment,
        sources: &Sources,
        sink: &mut Sink,
    ) -> Option<Robot> {
        let known = self.known.get((file.name.clone(), file.text.clone()), || {
            let mut found = Sink::default();
            read_robot(file, experiment, sources, &mut found).filter(|_| found.diagnostics.is_empty())
        });
        // Findings are not cached, as their places differ in each spec's texts.
        known.or_else(|| read_robot(file, experiment, sources, sink))
    }
}

/// The robot of a file; its mistakes go to the sink.
fn read_robot(
    file: &Attachment,
    experiment: &Experiment,
    sources: &Sources,
    sink: &mut Sink,
) -> Option<Robot> {
    let node = syntax::parse(sources, file.source, sink)?;
    let decoded = decode::table(&node, robot::file::PARAMS, sink)?;
    let (robot, issues) = robot::from_table(&file.name, &decoded.table);
    let named = experiment.marks.get(&section::Robot::model.path()).map(|mark| mark.value);
    let sound = issues.iter().all(|issue| issue.severity() == Severity::Warning);
    for found in issues {
        sink.emit(issue(&found, &decoded.marks, named));
    }
    robot.filter(|_| sound)
}

/// The decoded file of a motion. The text of a recording that it names is stored under `clip`, so that a
/// changed recording changes the motion.
pub fn read_motion(
    file: &Attachment,
    files: &dyn Files,
    reach: &Reach,
    sources: &Sources,
    sink: &mut Sink,
) -> Option<Table> {
    let node = syntax::parse(sources, file.source, sink)?;
    let Decoded { mut table, marks } = decode::kind(&node, &motion::kinds(), sink)?;
    let Some(name) = &Section::new(&table).value(Clip::file) else { return Some(table) };
    let text = match &file.path {
        Some(path) => {
            let path = path.with_file_name(name);
            reach.refusal(files, &path).map_or_else(|| syntax::file::read(files, &path), Err)
        }
        None => motion::embedded(name)
            .map(str::to_owned)
            .ok_or_else(|| Diagnostic::error("E0004", format!("file not found: `{name}`"))),
    };
    match text {
        Ok(text) => {
            table.insert(Clip::TEXT.name.into(), Value::Text(text));
            Some(table)
        }
        Err(diagnostic) => {
            sink.emit(match marks.get(Clip::file.name) {
                Some(mark) => diagnostic.at(mark.value, "a CSV file beside this one"),
                None => diagnostic,
            });
            None
        }
    }
}
