//! From a path to a checked experiment: loads the spec, robot and motion, and applies every rule.

use std::path::Path;
use std::sync::Arc;

use super::attached::read_motion;
use super::baseline::{self, Naming};
use super::checker::Checker;
use super::reference::{OnDemand, Reference};
use super::{
    Subject, chain, check, corners, exports, height, judging, motion_kind, overridden, parents, profiled,
    reference, relative, seeds, simulated, symmetry, terms,
};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::kinds::motion;
use crate::robot::{Robot, stated};
use crate::spec::family::Family;
use crate::spec::section::Report;
use crate::spec::suite::Arm;
use crate::spec::{Experiment, LoadOptions, Loaded, Section, Table, Vocabulary, allow};
use crate::syntax::{Disk, Files};

/// A spec with everything known before it is run.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// All texts.
    pub sources: Sources,
    /// All diagnostics, ordered by file and place, without allowed warnings.
    pub sink: Sink,
    /// The spec; complete only if the sink has no errors.
    pub experiment: Option<Experiment>,
    /// Its robot, if the robot file is valid.
    pub robot: Option<Robot>,
    /// The decoded file of its reference motion.
    pub motion: Option<Table>,
    /// The values of its baselines, in their order.
    pub baselines: Vec<Table>,
}

impl Checked {
    /// The spec and its robot, unless there are errors.
    pub fn sound(&self) -> Option<(&Experiment, &Robot)> {
        if self.sink.has_errors() { None } else { self.experiment.as_ref().zip(self.robot.as_ref()) }
    }
}

/// An arm of a suite with its robot and motion.
#[derive(Clone, Debug)]
pub struct CheckedArm {
    /// The arm.
    pub arm: Arm,
    /// Its robot, if the robot file is valid.
    pub robot: Option<Arc<Robot>>,
    /// The decoded file of its reference motion.
    pub motion: Option<Arc<Table>>,
}

/// Loads and checks a spec on disk.
pub fn checked(path: &Path, options: &LoadOptions) -> Checked {
    checked_in(&Disk, path, options)
}

/// Loads and checks a spec from any files, such as those open in an editor. The result depends only on these
/// files and the options; no state is kept between calls.
pub fn checked_in(files: &dyn Files, path: &Path, options: &LoadOptions) -> Checked {
    Checker::default().check(files, path, options)
}

impl Checker {
    /// Loads and checks a spec.
    pub fn check(&mut self, files: &dyn Files, path: &Path, options: &LoadOptions) -> Checked {
        let Loaded { sources, mut sink, experiment, family } = self.load(files, path, options);
        let Some(mut experiment) = experiment else { return Checked { sources, sink, ..Checked::default() } };
        let (named, reach) = (&experiment.baselines, &experiment.reach);
        let naming = Naming { files, by: path, named, reach, options };
        let mut in_baselines = Sink::default();
        // The checks under all profiles wait for both, so they are read at the same time.
        let (mut robot, baselines) = rayon::join(
            || {
                let file = experiment.robot.as_ref()?;
                self.robots.read(file, &experiment, &sources, &mut sink)
            },
            || {
                let tasks = baseline::task(&experiment).into_iter().collect();
                self.baselines(&naming, &tasks, &mut in_baselines)
            },
        );
        if let Some(robot) = &mut robot {
            stated::state(robot, &experiment.table);
            relative::resolve(&mut experiment, robot, &mut sink);
        }
        let motion = experiment
            .motion
            .as_ref()
            .and_then(|file| read_motion(file, files, &experiment.reach, &sources, &mut sink));
        let references = &self.references;
        let mut make = || {
            let [of, by] = [experiment.robot.as_ref()?, experiment.motion.as_ref()?];
            let key = [of, by].map(|file| (file.name.clone(), file.text.clone()));
            Some(reference::made(references, key.into(), motion.as_ref()?, robot.as_ref()?))
        };
        let parts = Parts { robot: robot.as_ref(), motion: motion.as_ref(), make: &mut make };
        let written = Written { experiment: &experiment, family: &family, sources: &sources };
        apply_rules(written, parts, &self.vocabulary, &mut self.simulated, &mut sink);
        seeds::learning_and_evaluations_are_apart(&experiment, &mut sink);
        find_compared(&experiment, files, &mut sink);
        sink.diagnostics.append(&mut in_baselines.diagnostics);
        finish(&experiment, options.deny_warnings, &mut sink);
        Checked { sources, sink, experiment: Some(experiment), robot, motion, baselines }
    }
}

/// A spec and the files that it was read from.
#[derive(Clone, Copy)]
pub(super) struct Written<'a> {
    /// The spec.
    pub experiment: &'a Experiment,
    /// Its files.
    pub family: &'a Family,
    /// Their texts.
    pub sources: &'a Sources,
}

/// What a spec names, and what is made of it on demand.
pub(super) struct Parts<'a> {
    /// The robot.
    pub robot: Option<&'a Robot>,
    /// The decoded file of the reference motion.
    pub motion: Option<&'a Table>,
    /// Makes the motion on the robot.
    pub make: &'a mut dyn FnMut() -> Option<Arc<Reference>>,
}

/// Applies every rule to a loaded spec with its robot and motion.
pub(super) fn apply_rules(
    Written { experiment, family, sources }: Written,
    Parts { robot, motion: file, make }: Parts,
    vocabulary: &Vocabulary,
    known: &mut simulated::Known,
    sink: &mut Sink,
) {
    let mut rules = Sink::default();
    let simulated = robot.map(|robot| stated::loaded(robot, &experiment.table));
    let subject =
        Subject { fields: &experiment.table, marks: &experiment.marks, robot: simulated.as_deref() };
    check(&subject, &mut rules);
    simulated::robots_stay_usable(&subject, robot, known, &mut rules);
    terms::some_are_switched_on(&subject, experiment, &mut rules);
    let period = file.and_then(|file| motion::period(Section::new(file)));
    judging::evaluations_are_long_enough(&subject, period, &mut rules);
    exports::transfers_have_a_policy(&subject, experiment, &mut rules);
    let mut reference = OnDemand { shipped: reference::shipped(experiment, vocabulary), make };
    reference::suits(&subject, &mut reference, &mut rules);
    symmetry::motions_are_mirrored(&subject, file, &mut reference, &mut rules);
    motion_kind::motions_are_of_the_task(&subject, file, &mut rules);
    reference::stays_apart(&subject, &mut reference, &mut rules);
    reference::stays_below_velocity_limits(&subject, &mut reference, &mut rules);
    corners::squats_are_smooth(&subject, &mut reference, &mut rules);
    height::references_stay_above(&subject, &mut reference, &mut rules);
    let files: Vec<_> = family.members.iter().map(|member| member.source).collect();
    rules
        .diagnostics
        .iter_mut()
        .for_each(|found| chain::blame_the_last_writer(found, &experiment.marks, &files));
    rules
        .diagnostics
        .iter_mut()
        .for_each(|found| chain::edit_own_file(found, &experiment.marks, experiment.source));
    sink.diagnostics.append(&mut rules.diagnostics);
    parents::lost_keys(experiment, family, vocabulary, sink);
    overridden::keys_are_read(&subject, experiment, sink);
    profiled::own_values_last(experiment, family, sources, sink);
}

/// Shows replaced values, sorts the diagnostics, drops those that the spec allows, and turns denied warnings
/// into errors.
pub(super) fn finish(experiment: &Experiment, deny_warnings: bool, sink: &mut Sink) {
    sink.diagnostics.iter_mut().for_each(|found| chain::show_what_was_replaced(found, experiment));
    sink.diagnostics
        .sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
    allow::apply(sink, &experiment.allow, deny_warnings);
}

/// Why a valid spec cannot be run: it is abstract (E0606).
pub fn unrunnable(experiment: &Experiment, sources: &Sources) -> Option<Diagnostic> {
    experiment.is_abstract.then(|| {
        let message = format!("`{}` is abstract and cannot be run", experiment.name);
        let start = sources.get(experiment.source).text.find("abstract").unwrap_or(0);
        let place = Span { source: experiment.source, start, end: start + "abstract".len() };
        let advice = "run a spec that extends it, or write one with `extends`";
        Diagnostic::error("E0606", message).at(place, "not inherited by children").help(advice)
    })
}

/// The specs of `report.compare` exist (E0004).
fn find_compared(experiment: &Experiment, files: &dyn Files, sink: &mut Sink) {
    let own = files.identity(&experiment.path);
    for (index, path) in experiment.compare.iter().enumerate() {
        let mark = experiment.marks.nearest(&Report::compared(index));
        // A list that several specs inherit may name each of them.
        let is_own = mark.is_some_and(|mark| mark.value.source == experiment.source);
        if let Some(mark) = mark.filter(|_| is_own && files.identity(path) == own) {
            let message = format!("`{}` compares itself with itself", experiment.name);
            let error = Diagnostic::error("E0816", message).at(mark.value, "this very file");
            sink.emit(error.help("name another spec, or remove the entry"));
            continue;
        }
        let before = experiment.compare[..index]
            .iter()
            .position(|other| files.identity(other) == files.identity(path));
        if let (Some(mark), Some(before)) = (mark, before) {
            let message = format!("`{}` is compared with twice", crate::escape::file(path));
            let error = Diagnostic::error("E0816", message).at(mark.value, "again");
            let first = experiment.marks.nearest(&Report::compared(before));
            let error = first.into_iter().fold(error, |error, first| error.note(first.value, "first here"));
            sink.emit(error.help("name another spec, or remove the entry"));
            continue;
        }
        let refusal = experiment.reach.refusal(files, path);
        let Some(diagnostic) =
            refusal.or_else(|| (!files.is_file(path)).then(|| baseline::missing(files, path)))
        else {
            continue;
        };
        sink.emit(match experiment.marks.nearest(&Report::compared(index)) {
            Some(mark) => diagnostic.at(mark.value, "relative to this file"),
            None => diagnostic,
        });
    }
}
