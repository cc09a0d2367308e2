//! The specs that a report compares its arms with (`report.baseline`): each one is valid, and each arm has
//! one for its task (E0608).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::checker::Checker;
use super::relative;
use crate::diag::{Diagnostic, Severity, Sink, Sources};
use crate::escape;
use crate::kinds::action::Action;
use crate::kinds::task::Task;
use crate::robot::stated;
use crate::spec::suite::is_suite;
use crate::spec::typed::InSection;
use crate::spec::{Experiment, LoadOptions, Loaded, NamedSpec, Reach, Section, Table};
use crate::syntax::{self, Files};

/// Maximum depth to which baselines of baselines are followed; a longer chain is not a cycle.
const DEEPEST: usize = 32;

/// What names the baselines.
pub(super) struct Naming<'a> {
    pub files: &'a dyn Files,
    /// Its path.
    pub by: &'a Path,
    pub named: &'a [NamedSpec],
    pub reach: &'a Reach,
    /// The options for checking it; baselines have no profile and no assignments.
    pub options: &'a LoadOptions,
}

impl Naming<'_> {
    fn plain_options(&self) -> LoadOptions {
        LoadOptions {
            allow_outside: self.options.allow_outside.clone(),
            without_profiles: true,
            ..LoadOptions::default()
        }
    }
}

/// The task of a spec.
pub(super) fn task(experiment: &Experiment) -> Option<String> {
    Some(Section::new(&experiment.table).within::<Task>()?.kind()?.to_owned())
}

impl Checker {
    /// The values of the baselines, in order, for arms with these tasks. Mistakes in a baseline are reported
    /// where it is named.
    pub(super) fn baselines(
        &self,
        naming: &Naming<'_>,
        tasks: &BTreeSet<String>,
        sink: &mut Sink,
    ) -> Vec<Table> {
        let mut found: Vec<Experiment> = Vec::new();
        for named in naming.named {
            match self.baseline(naming, &named.path) {
                Ok(experiment) => found.push(experiment),
                Err(error) => sink.emit(at(error, named)),
            }
        }
        // Whether one is missing is known only once all are loaded.
        if let Some(first) = naming.named.first().filter(|_| found.len() == naming.named.len()) {
            let there: BTreeSet<String> = found.iter().filter_map(task).collect();
            tasks.difference(&there).for_each(|task| sink.emit(at(of_another_task(task, &there), first)));
        }
        let sound = found.len() == naming.named.len();
        for (place, named) in naming.named.iter().enumerate().filter(|_| sound) {
            let first = (0..place).find(|first| of(&found[*first]) == of(&found[place]));
            first.into_iter().for_each(|first| sink.emit(twice(&naming.named[first], named, &found[place])));
        }
        found.into_iter().map(|experiment| experiment.table).collect()
    }

    /// A baseline without profile and assignments.
    fn baseline(&self, naming: &Naming<'_>, path: &Path) -> Result<Experiment, Diagnostic> {
        let shown = escape::file(path);
        let wrong = |message: String, advice: &str| Err(Diagnostic::error("E0608", message).help(advice));
        if let Some(refusal) = naming.reach.refusal(naming.files, path) {
            return Err(refusal);
        }
        if !naming.files.is_file(path) {
            return Err(missing(naming.files, path));
        }
        if is_suite(&syntax::file::read(naming.files, path)?) {
            return wrong(
                format!("the baseline `{shown}` is a suite"),
                "name one of the specs that the suite varies",
            );
        }
        let loaded = self.plain(naming, path);
        let mut trail = Trail { steps: vec![naming.files.identity(naming.by)], done: BTreeSet::new() };
        if let Some(circle) = self.circle(naming, path, &loaded, &mut trail) {
            let names: Vec<String> = circle.iter().map(|step| format!("`{}`", file_name(step))).collect();
            let advice = "remove `baseline` from one of these specs, or name another spec";
            return match circle.as_slice() {
                [own, _] => wrong(format!("`{}` is its own baseline", file_name(own)), advice),
                _ => wrong(format!("cycle of baselines: {}", names.join(", ")), advice),
            };
        }
        let mut errors = loaded.sink.diagnostics.iter().filter(|found| found.severity == Severity::Error);
        match (errors.next(), &loaded.experiment) {
            (None, Some(experiment)) if experiment.is_abstract => {
                let advice = "name a spec that extends it: a baseline needs all keys";
                wrong(format!("the baseline `{shown}` is abstract"), advice)
            }
            (None, Some(experiment)) => Ok(self.for_its_robot(experiment.clone(), &loaded.sources)),
            (first, _) => {
                let first = first.map_or(String::new(), |first| format!(": {}", first.message));
                let advice =
                    format!("run `specforge check {}` and fix its errors", escape::shell::argument(path));
                wrong(format!("the baseline `{shown}` has errors{first}"), &advice)
            }
        }
    }

    /// A baseline whose quantities relative to the robot are shares of its own robot's figures.
    fn for_its_robot(&self, mut experiment: Experiment, sources: &Sources) -> Experiment {
        let Some(file) = experiment.robot.clone().filter(|_| relative::any(&experiment.table)) else {
            return experiment;
        };
        // Mistakes in the robot are reported by a check of the baseline itself.
        let mut silent = Sink::default();
        if let Some(mut robot) = self.robots.read(&file, &experiment, sources, &mut silent) {
            stated::state(&mut robot, &experiment.table);
            relative::resolve(&mut experiment, &robot, &mut silent);
        }
        experiment
    }

    /// Loads a baseline without profiles and assignments, or returns it if it was loaded before.
    fn plain(&self, naming: &Naming<'_>, path: &Path) -> Arc<Loaded> {
        let load = || Arc::new(self.load(naming.files, path, &naming.plain_options()));
        match &self.specs {
            Some(specs) => specs.baselines.get(path.to_owned(), load),
            None => load(),
        }
    }

    /// The files of a cycle of baselines reachable from a loaded spec; `None` without a cycle.
    fn circle(
        &self,
        naming: &Naming<'_>,
        path: &Path,
        loaded: &Loaded,
        trail: &mut Trail,
    ) -> Option<Vec<PathBuf>> {
        let own = naming.files.identity(path);
        if let Some(start) = trail.steps.iter().position(|step| *step == own) {
            return Some([&trail.steps[start..], &[own]].concat());
        }
        if trail.steps.len() >= DEEPEST || !trail.done.insert(own.clone()) {
            return None;
        }
        trail.steps.push(own);
        let next = loaded.experiment.iter().flat_map(|experiment| &experiment.baselines);
        let circle = next.filter(|named| naming.files.is_file(&named.path)).find_map(|named| {
            let loaded = self.plain(naming, &named.path);
            self.circle(naming, &named.path, &loaded, trail)
        });
        trail.steps.pop();
        circle
    }
}

/// E0004 for a spec that another one names, without a place.
pub(super) fn missing(files: &dyn Files, path: &Path) -> Diagnostic {
    let error = Diagnostic::error("E0004", format!("file not found: `{}`", escape::file(path)));
    let advice = syntax::file::elsewhere(files, path);
    error.help(advice.unwrap_or("name a spec by its path relative to this file".into()))
}

/// The chain of baselines from a spec.
struct Trail {
    steps: Vec<PathBuf>,
    /// Specs known not to lead to a cycle.
    done: BTreeSet<PathBuf>,
}

/// The task and the kind of action, which select an arm's baseline.
fn of(experiment: &Experiment) -> [Option<String>; 2] {
    [Task::SECTION, Action::SECTION].map(|section| Some(experiment.section(section)?.kind()?.to_owned()))
}

/// E0608: of two baselines with the same task and action, the second would never be used.
fn twice(first: &NamedSpec, second: &NamedSpec, experiment: &Experiment) -> Diagnostic {
    let [task, action] = of(experiment).map(Option::unwrap_or_default);
    let [one, other] = [first, second].map(|named| escape::file(&named.path));
    let message =
        format!("two baselines for the task `{task}` and the action `{action}`: `{one}` and `{other}`");
    let error = at(Diagnostic::error("E0608", message), second);
    let error = match first.place {
        Some(place) => error.note(place, "only this one would be used"),
        None => error,
    };
    error.help("remove one of them: a list can have one baseline per task and kind of action")
}

fn of_another_task(task: &str, there: &BTreeSet<String>) -> Diagnostic {
    let names: Vec<String> = there.iter().map(|name| format!("`{name}`")).collect();
    let message = match names.as_slice() {
        [one] => format!("the arm has the task `{task}`, but its baseline has {one}"),
        several => format!("the arm has the task `{task}`, but its baselines have {}", several.join(", ")),
    };
    let advice = format!("add a baseline with the task `{task}`: a list can have one per task");
    Diagnostic::error("E0608", message).help(advice)
}

fn at(error: Diagnostic, named: &NamedSpec) -> Diagnostic {
    match named.place {
        Some(place) => error.at(place, "relative to this file"),
        None => error,
    }
}

fn file_name(path: &Path) -> String {
    escape::file(Path::new(path.file_name().unwrap_or_default()))
}
