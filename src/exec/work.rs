//! The interface between the scheduler and the implementations of stages.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use super::events::{Event, Events};
use super::fault::StoreError;
use super::interrupt::Interrupt;
use crate::bounded;
use crate::finite::{self, NotFinite};
use crate::learn::LearnError;
use crate::plan::{Plan, Stage, StageKind};
use crate::sim::{EngineError, EngineName};
use crate::spec::typed::Part;
use crate::spec::{Section, Table};

/// The implementation of one kind of stage.
pub trait Work: Send + Sync {
    /// Makes the artefact: reads `job.fields` and `job.inputs`, writes files into `job.output`.
    ///
    /// The same fields and inputs must give the same files for any number of threads. After an interruption
    /// or a crash it is called again with the same scratch folder, and continues from there.
    fn run(&self, job: &Job) -> Result<(), WorkError>;
}

/// The implementations by kind of stage.
pub type Works = BTreeMap<StageKind, Box<dyn Work>>;

/// One stage to perform.
pub struct Job<'a> {
    /// The stage.
    pub stage: &'a Stage,
    /// Its name for people, as in events.
    pub label: String,
    /// The whole plan; a report needs its arms' records and the stages of each role.
    pub plan: &'a Plan,
    /// Only the declared fields. An `evaluate.NAME` or `deploy.NAME` table is named `evaluate` or `deploy`
    /// here.
    pub fields: &'a Table,
    /// The folders of the inputs by role (`env`, `learner`; for a report `ARM/STAGE`).
    pub inputs: BTreeMap<String, PathBuf>,
    /// An empty folder for the artefact's files.
    pub output: &'a Path,
    /// A folder that survives interruptions and crashes, for checkpoints; removed after success.
    pub scratch: &'a Path,
    /// How many threads the stage may use; can change while it runs.
    pub threads: Threads,
    /// Receives progress and warnings.
    pub events: &'a dyn Events,
    /// Whether a stop was requested.
    pub interrupt: &'a Interrupt,
    /// For a report: stages of other arms that failed, whose artefacts are missing from `inputs`.
    pub failures: &'a [Failure],
}

impl Job<'_> {
    /// A view of a declared section.
    pub fn section(&self, name: &str) -> Option<Section<'_>> {
        Section::new(self.fields).section(name)
    }

    /// A declared section, decoded.
    pub fn part<P: Part>(&self) -> Option<P> {
        Section::new(self.fields).part()
    }

    /// Reports progress.
    pub fn progress(&self, done: u64, total: u64, unit: &str, note: impl Into<String>) {
        let (stage, unit, note) = (self.label.clone(), unit.to_owned(), note.into());
        self.events.emit(Event::Progress { stage, done, total, unit, note });
    }

    /// Reports measured values.
    pub fn metric(&self, values: BTreeMap<String, f64>) {
        self.events.emit(Event::Metric { stage: self.label.clone(), values });
    }

    /// Reports a problem that does not stop the stage.
    pub fn warning(&self, message: impl Into<String>) {
        let (stage, message) = (Some(self.label.clone()), message.into());
        self.events.emit(Event::Warning { stage, code: None, message, help: None });
    }

    /// Reports the finding of a run-time check, unless every arm that uses the stage allows it.
    pub fn finding(&self, code: &str, message: String, help: &str) {
        if !self.plan.allows(self.stage, code) {
            let (stage, help) = (Some(self.label.clone()), Some(help.to_owned()));
            self.events.emit(Event::Warning { stage, code: Some(code.to_owned()), message, help });
        }
    }

    /// The path of a file of an input.
    pub fn input(&self, role: &str, file: &str) -> Result<PathBuf, WorkError> {
        match self.inputs.get(role) {
            Some(folder) => Ok(folder.join(file)),
            None => Err(WorkError::failed(format!("the input `{role}` is missing"))),
        }
    }

    /// Reads a JSON file of an input.
    pub fn read<T: serde::de::DeserializeOwned>(&self, role: &str, file: &str) -> Result<T, WorkError> {
        let path = self.input(role, file)?;
        let text =
            bounded::text(&path, bounded::RECORD).map_err(|error| WorkError::io(&path, error.into()))?;
        serde_json::from_str(&text).map_err(|error| WorkError::failed(format!("{}: {error}", path.display())))
    }

    /// Writes a JSON file of the artefact.
    pub fn write<T: Serialize>(&self, file: &str, value: &T) -> Result<(), WorkError> {
        let text = finite::to_string(value).map_err(|found| WorkError::not_finite(file, &found))?;
        self.write_text(file, &text)
    }

    /// Writes a file of the artefact.
    pub fn write_text(&self, file: &str, text: &str) -> Result<(), WorkError> {
        let path = self.output.join(file);
        std::fs::write(&path, text).map_err(|error| WorkError::io(&path, error))
    }
}

/// A stage's share of the threads. The scheduler changes it as other stages start and end. Stages that can
/// adapt read it between steps, others only once.
#[derive(Clone, Debug)]
pub struct Threads(Arc<AtomicUsize>);

impl Threads {
    /// A share of this many threads.
    pub fn new(count: usize) -> Self {
        Self(Arc::new(AtomicUsize::new(count.max(1))))
    }

    /// The current share, at least 1.
    pub fn now(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }

    /// Changes the share.
    pub fn set(&self, count: usize) {
        self.0.store(count.max(1), Ordering::Relaxed);
    }
}

/// Why a stage did not finish.
#[derive(Debug, thiserror::Error)]
pub enum WorkError {
    /// The user requested a stop; the scratch folder contains what is needed to continue.
    #[error("interrupted")]
    Interrupted,
    /// The stage failed.
    #[error("{message}")]
    Failed {
        /// The diagnostic's code (`R0001`), if it has one.
        code: Option<&'static str>,
        /// What happened.
        message: String,
        /// How to fix it.
        help: Option<String>,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<EngineError> for WorkError {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::LibraryMissing { engine, .. } => {
                let help = EngineName::named(engine)
                    .map_or("`specforge list engines` lists them", |engine| engine.facts().cure);
                Self::coded("R0005", error.to_string(), help)
            }
            error => Self::failed(error.to_string()),
        }
    }
}

impl From<LearnError> for WorkError {
    fn from(error: LearnError) -> Self {
        match error {
            LearnError::Interrupted => Self::Interrupted,
            LearnError::File { path, error } => Self::io(&path, error),
            LearnError::NotFinite { file, found } => Self::not_finite(&file, &found),
            error => Self::Failed { code: error.code(), message: error.to_string(), help: error.help() },
        }
    }
}

impl WorkError {
    /// A failure without a code.
    pub fn failed(message: impl Into<String>) -> Self {
        Self::Failed { code: None, message: message.into(), help: None }
    }

    /// A failure with a code and advice.
    pub fn coded(code: &'static str, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Failed { code: Some(code), message: message.into(), help: Some(help.into()) }
    }

    /// A result contains NaN or infinity.
    pub fn not_finite(file: &str, found: &NotFinite) -> Self {
        let help = "look at what the number is made of: a robot's figures, a reward, a rate; `specforge \
            explain R0007` says more";
        Self::coded("R0007", format!("the result is not finite: {file}: {found}"), help)
    }

    /// A failure of the file system.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        // A full or read-only disk has its own code, whichever stage meets it.
        match StoreError::writing(path, source) {
            StoreError::Io { path, source } => Self::Io { path, source },
            fault => Self::Store(fault),
        }
    }

    /// The diagnostic's code and how to fix it, if there are any.
    pub fn advice(&self) -> (Option<&'static str>, Option<String>) {
        match self {
            Self::Failed { code, help, .. } => (*code, help.clone()),
            Self::Store(fault) => (fault.code(), fault.help().map(Into::into)),
            Self::Interrupted | Self::Io { .. } => (None, None),
        }
    }
}

/// A stage that failed, as reported.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The stage's name for people.
    pub stage: String,
    /// The arms that need the stage.
    pub arms: Vec<String>,
    /// The diagnostic's code, if it has one.
    pub code: Option<String>,
    /// What happened.
    pub message: String,
    /// How to fix it.
    pub help: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_engine_that_is_unknown_is_r0005_and_sends_to_the_list() {
        let missing = crate::sim::open("bullet").err().expect("there is no such engine");
        let (code, help) = WorkError::from(missing).advice();
        assert_eq!((code, help.as_deref()), (Some("R0005"), Some("`specforge list engines` lists them")));
    }

    #[cfg(feature = "mujoco")]
    #[test]
    fn for_a_missing_library_of_mujoco_the_variable_that_names_it_is_told() {
        let missing = EngineError::LibraryMissing { engine: "mujoco", reason: "no such file".into() };
        let (code, help) = WorkError::from(missing).advice();
        assert_eq!(code, Some("R0005"));
        assert!(help.is_some_and(|help| help.contains("SPECFORGE_MUJOCO") && help.contains("make native")));
    }
}
