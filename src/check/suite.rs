//! From the path of a suite to its checked arms: loads specs, robots and motions (each read once), and
//! applies every rule.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::attached::{Robots, read_motion};
use super::baseline::{self, Naming};
use super::checked::{CheckedArm, Parts, Written, apply_rules, finish};
use super::checker::Checker;
use super::claims::{self, ArmScope, Scope};
use super::reference::{self, Reference, References};
use super::simulated::Known;
use super::{arms, budget, figures, relative, seeds};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::robot::{Robot, stated};
use crate::spec::claim::Claim;
use crate::spec::suite::sweep::Grasp;
use crate::spec::suite::{Axis, ClaimPolicy, LoadedArm, LoadedSuite, Suite, load};
use crate::spec::{Attachment, Experiment, LoadOptions, Reach, Table, Vocabulary, allow, section};
use crate::syntax::{Disk, Files};

/// A suite with everything known before it is run.
#[derive(Clone, Debug, Default)]
pub struct CheckedSuite {
    /// All texts.
    pub sources: Sources,
    /// All diagnostics, each mistake once however many arms share it.
    pub sink: Sink,
    /// The suite; absent if its file is invalid. If its sweep has mistakes (see `grasp`), the arms are those
    /// of the valid part.
    pub suite: Option<Suite>,
    /// Its arms in the order of the sweep; complete only if the sink has no errors.
    pub arms: Vec<CheckedArm>,
    /// Its valid claims.
    pub claims: Vec<Claim>,
    /// The values of its report's baselines, in order.
    pub baselines: Vec<Table>,
}

impl CheckedSuite {
    /// The suite and its arms, unless there are errors.
    pub fn sound(&self) -> Option<(&Suite, &[CheckedArm])> {
        if self.sink.has_errors() {
            None
        } else {
            self.suite.as_ref().map(|suite| (suite, self.arms.as_slice()))
        }
    }
}

/// Loads and checks a suite on disk.
pub fn suite(path: &Path, options: &LoadOptions) -> CheckedSuite {
    suite_in(&Disk, path, options)
}

/// Loads and checks a suite from any files.
pub fn suite_in(files: &dyn Files, path: &Path, options: &LoadOptions) -> CheckedSuite {
    Checker::default().suite(files, path, options)
}

impl Checker {
    /// Loads and checks a suite. Cached robots are not read again.
    pub fn suite(&mut self, files: &dyn Files, path: &Path, options: &LoadOptions) -> CheckedSuite {
        let loaded = load(files, path, options, &self.vocabulary);
        let shared =
            Shared { vocabulary: &self.vocabulary, robots: &self.robots, simulated: &mut self.simulated };
        let mut checked = examined(files, options, loaded, shared);
        let CheckedSuite { suite: Some(suite), arms, sink, .. } = &mut checked else { return checked };
        let Some(first) = arms.first() else { return checked };
        let tasks = arms.iter().filter_map(|arm| baseline::task(&arm.arm.experiment)).collect();
        let (named, reach) = (&suite.baselines, &first.arm.experiment.reach);
        let baselines = self.baselines(&Naming { files, by: path, named, reach, options }, &tasks, sink);
        checked.baselines = baselines;
        checked
    }
}

/// What the checks of several suites share.
struct Shared<'a> {
    vocabulary: &'a Vocabulary,
    /// Robots read so far.
    robots: &'a Robots,
    /// Findings about simulated robots so far.
    simulated: &'a mut Known,
}

/// Applies every rule to the arms of a loaded suite.
fn examined(
    files: &dyn Files,
    options: &LoadOptions,
    loaded: LoadedSuite,
    Shared { vocabulary, robots: known, simulated }: Shared,
) -> CheckedSuite {
    let LoadedSuite { sources, mut sink, suite, arms } = loaded;
    let mut shelf = Shelf::new(files, &sources, known);
    let (mut found, mut checked) = (Vec::new(), Vec::new());
    for LoadedArm { mut arm, family, sink: mut own } in arms {
        let experiment = &mut arm.experiment;
        let mut robot = experiment.robot.as_ref().and_then(|file| shelf.robot(file, experiment, &mut own));
        if let Some(robot) = robot.as_mut().filter(|_| stated::any(&experiment.table)) {
            stated::state(Arc::make_mut(robot), &experiment.table);
        }
        if let Some(robot) = &robot {
            relative::resolve(experiment, robot, &mut own);
        }
        let experiment = &arm.experiment;
        let motion =
            experiment.motion.as_ref().and_then(|file| shelf.motion(file, &experiment.reach, &mut own));
        let mut make = || shelf.reference(experiment, robot.as_deref(), motion.as_deref());
        let parts = Parts { robot: robot.as_deref(), motion: motion.as_deref(), make: &mut make };
        apply_rules(
            Written { experiment, family: &family, sources: &sources },
            parts,
            vocabulary,
            simulated,
            &mut own,
        );
        if let Some(suite) = &suite {
            match suite.sweep.seeds {
                Some(_) => seeds::sweep_and_evaluations_are_apart(&suite.sweep, experiment, &mut own),
                None => seeds::learning_and_evaluations_are_apart(experiment, &mut own),
            }
        }
        finish(experiment, options.deny_warnings, &mut own);
        found.push(own.diagnostics);
        checked.push(CheckedArm { arm, robot, motion });
    }
    if let Some(suite) = &suite {
        if suite.sweep.grasp != Grasp::Full {
            arms::keep_certain(&checked, &mut found);
        }
        arms::gather(suite, &checked, found, &mut sink);
        budget::arms_take_equal_samples(&checked, &mut sink);
    }
    let claims = match &suite {
        Some(suite) if !sink.has_errors() => {
            let shortened = options.profile.is_some() || !options.sets.is_empty();
            checked_claims(suite, &Scope { shortened, ..scope(suite, &checked) }, &checked, &mut sink)
        }
        // Claims are checked against the arms only if those are valid; the rest is always checked.
        Some(suite) => {
            let scope = scope(suite, &checked);
            let axes = (suite.sweep.grasp != Grasp::Part).then_some(&scope);
            claims::alone(&suite.claims, axes, &mut sink);
            sink.diagnostics
                .sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
            Vec::new()
        }
        None => Vec::new(),
    };
    if let Some(suite) = suite.as_ref().filter(|suite| suite.sweep.grasp == Grasp::Full) {
        figures::produced(&suite.figures, &checked, &mut sink);
    }
    if options.deny_warnings {
        allow::apply(&mut sink, &BTreeMap::new(), true);
    }
    CheckedSuite { sources, sink, suite, arms: checked, claims, baselines: Vec::new() }
}

/// The claims, reporting their mistakes. `[allow]` of the suite reaches every arm, so the first arm's is
/// used.
fn checked_claims(suite: &Suite, scope: &Scope, arms: &[CheckedArm], sink: &mut Sink) -> Vec<Claim> {
    let mut own = Sink::default();
    let claims = claims::claims(&suite.claims, scope, &mut own);
    if let Some(first) = arms.first() {
        allow::apply(&mut own, &first.arm.experiment.allow, false);
    }
    sink.diagnostics.extend(own.diagnostics);
    claims
}

/// What claims can refer to.
fn scope<'a>(suite: &'a Suite, arms: &'a [CheckedArm]) -> Scope<'a> {
    let axis =
        |axis: &'a Axis| (axis.name.as_str(), axis.points.iter().map(|point| point.name.as_str()).collect());
    let seeds = suite.sweep.seeds.as_deref();
    let arm = |checked: &'a CheckedArm| ArmScope {
        points: &checked.arm.points,
        fields: &checked.arm.experiment.table,
        robot: checked.robot.as_deref(),
        runs: suite.sweep.seeds_of(&checked.arm.points).map_or(1, |seeds| seeds.len()),
    };
    Scope {
        axes: suite.sweep.axes.iter().map(axis).collect(),
        arms: arms.iter().map(arm).collect(),
        seeds: seeds.and_then(|seeds| seeds.first()).map(|(_, place)| *place),
        counted: suite.policy == ClaimPolicy::Count,
        shortened: false,
    }
}

/// Robots and motions read so far, with their mistakes.
struct Shelf<'a> {
    files: &'a dyn Files,
    sources: &'a Sources,
    /// Valid robots by their whole text, also those of other suites.
    known: &'a Robots,
    robots: BTreeMap<(SourceId, Option<Span>), Read<Robot>>,
    motions: BTreeMap<SourceId, Read<Table>>,
    references: References<(SourceId, SourceId)>,
}

type Read<T> = (Option<Arc<T>>, Vec<Diagnostic>);

impl<'a> Shelf<'a> {
    fn new(files: &'a dyn Files, sources: &'a Sources, known: &'a Robots) -> Self {
        let (robots, motions) = (BTreeMap::new(), BTreeMap::new());
        Self { files, sources, known, robots, motions, references: References::default() }
    }

    /// The robot of a file; its mistakes are reported for every arm that uses it.
    fn robot(&mut self, file: &Attachment, experiment: &Experiment, sink: &mut Sink) -> Option<Arc<Robot>> {
        let named = experiment.marks.get(&section::Robot::model.path()).map(|mark| mark.value);
        let read = self.robots.entry((file.source, named)).or_insert_with(|| {
            let mut found = Sink::default();
            let robot = self.known.read(file, experiment, self.sources, &mut found);
            (robot.map(Arc::new), found.diagnostics)
        });
        sink.diagnostics.extend(read.1.iter().cloned());
        read.0.clone()
    }

    fn motion(&mut self, file: &Attachment, reach: &Reach, sink: &mut Sink) -> Option<Arc<Table>> {
        let read = self.motions.entry(file.source).or_insert_with(|| {
            let mut found = Sink::default();
            let motion = read_motion(file, self.files, reach, self.sources, &mut found);
            (motion.map(Arc::new), found.diagnostics)
        });
        sink.diagnostics.extend(read.1.iter().cloned());
        read.0.clone()
    }

    /// The reference motion on the robot.
    fn reference(
        &mut self,
        experiment: &Experiment,
        robot: Option<&Robot>,
        motion: Option<&Table>,
    ) -> Option<Arc<Reference>> {
        let key = (experiment.robot.as_ref()?.source, experiment.motion.as_ref()?.source);
        Some(reference::made(&self.references, key, motion?, robot?))
    }
}
