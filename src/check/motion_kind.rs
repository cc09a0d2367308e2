//! W0526: a reference motion of another kind than the task.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::{run_gait::RunGait, squat::Squat, walk::Walk};
use crate::kinds::task::run::Run;
use crate::kinds::task::squat::Squat as SquatTask;
use crate::kinds::task::walk::Walk as WalkTask;
use crate::spec::marks;
use crate::spec::typed::{Declared, InSection};
use crate::spec::value::KIND;
use crate::spec::{Section, Table};

/// The kinds of motions and the tasks that they are for. A clip is a recording of anything.
const OF_TASK: [(&str, &str); 3] = [
    (Walk::KIND.name, WalkTask::KIND.name),
    (RunGait::KIND.name, Run::KIND.name),
    (Squat::KIND.name, SquatTask::KIND.name),
];

/// A task has a motion of its own kind.
pub fn motions_are_of_the_task(subject: &Subject, file: Option<&Table>, sink: &mut Sink) {
    let kind = file.and_then(|file| Section::new(file).kind());
    let Some(own) = OF_TASK.iter().find(|(motion, _)| Some(*motion) == kind).map(|(_, task)| *task) else {
        return;
    };
    let is_other = |task: &&str| *task != own && OF_TASK.iter().any(|(_, known)| known == task);
    let Some(task) = subject.kind("task").filter(is_other) else { return };
    // The same cause has been reported.
    if sink.diagnostics.iter().any(|found| found.code == "E0513") {
        return;
    }
    let name = subject.motion();
    let message = format!("the motion `{name}` is one of the task `{own}`, and the task is `{task}`");
    let mut diagnostic = Diagnostic::warning("W0526", message);
    if let Some(place) = subject.place(&WalkTask::motion.path()) {
        diagnostic = diagnostic.at(place, "its contacts and speed are those of another gait");
    }
    if let Some(place) = subject.place(&marks::below(WalkTask::SECTION, KIND)) {
        diagnostic = diagnostic.note(place, "the task");
    }
    let fitting = OF_TASK.iter().find(|(_, own)| *own == task).map_or("", |(motion, _)| *motion);
    sink.emit(diagnostic.help(format!(
        "name a motion of the kind `{fitting}` or `clip`, or write `kind = \"{own}\"` in `[task]`"
    )));
}
