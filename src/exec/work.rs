//! The contract between the scheduler and the work of a stage.

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
use crate::sim::EngineError;
use crate::spec::typed::Part;
use crate::spec::{Section, Table};

/// The work of one kind of stage.
pub trait Work: Send + Sync {
    /// Makes the artefact: reads `job.fields` and `job.inputs`, writes files into `job.output`.
    ///
    /// The same fields and inputs must give the same files, whatever the threads. After an
    /// interruption or a crash it is called again with the same scratch folder and goes on from there.
    fn run(&self, job: &Job) -> Result<(), WorkError>;
}

/// The works by kind of stage.
pub type Works = BTreeMap<StageKind, Box<dyn Work>>;

/// One stage to be worked on.
pub struct Job<'a> {
    /// The stage.
    pub stage: &'a Stage,
    /// Its name for people, as in events.
    pub label: String,
    /// The whole plan, for a report: its arms' records and the stages of each role.
    pub plan: &'a Plan,
    /// The declared fields and no others. An `evaluate.NAME` or `deploy.NAME` table is `evaluate` or
    /// `deploy` here.
    pub fields: &'a Table,
    /// The folders of the inputs by role (`env`, `learner`; for a report `ARM/STAGE`).
    pub inputs: BTreeMap<String, PathBuf>,
    /// An empty folder for the artefact's files.
    pub output: &'a Path,
    /// A folder that survives interruptions and crashes, for checkpoints; removed after success.
    pub scratch: &'a Path,
    /// How many threads it may use at this moment.
    pub threads: Threads,
    /// Where progress is told.
    pub events: &'a dyn Events,
    /// Whether the user wants to stop.
    pub interrupt: &'a Interrupt,
    /// For a report: stages of other arms that failed. Their artefacts are absent from `inputs`.
    pub failures: &'a [Failure],
}

impl Job<'_> {
    /// A view of a declared section.
    pub fn section(&self, name: &str) -> Option<Section<'_>> {
        Section::new(self.fields).section(name)
    }

    /// A declared section in Rust.
    pub fn part<P: Part>(&self) -> Option<P> {
        Section::new(self.fields).part()
    }

    /// Tells how far the work is.
    pub fn progress(&self, done: u64, total: u64, unit: &str, note: impl Into<String>) {
        let (stage, unit, note) = (self.label.clone(), unit.to_owned(), note.into());
        self.events.emit(Event::Progress { stage, done, total, unit, note });
    }

    /// Tells numbers that the work has measured.
    pub fn metric(&self, values: BTreeMap<String, f64>) {
        self.events.emit(Event::Metric { stage: self.label.clone(), values });
    }

    /// Tells something that the user should know and that stops nothing.
    pub fn warning(&self, message: impl Into<String>) {
        let (stage, message) = (Some(self.label.clone()), message.into());
        self.events.emit(Event::Warning { stage, code: None, message, help: None });
    }

    /// Tells what a run-time check has found, unless every arm that uses the stage means it.
    pub fn finding(&self, code: &str, message: String, help: &str) {
        if !self.plan.allows(self.stage, code) {
            let (stage, help) = (Some(self.label.clone()), Some(help.to_owned()));
            self.events.emit(Event::Warning { stage, code: Some(code.to_owned()), message, help });
        }
    }

    /// A file of an input.
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

/// A stage's share of the machine. The scheduler changes it while the stage runs, as others start and
/// end; a work that can follows it between two steps, others ask once.
#[derive(Clone, Debug)]
pub struct Threads(Arc<AtomicUsize>);

impl Threads {
    /// A share of this many threads.
    pub fn new(count: usize) -> Self {
        Self(Arc::new(AtomicUsize::new(count.max(1))))
    }

    /// The share at this moment, at least 1.
    pub fn now(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }

    /// Changes the share.
    pub fn set(&self, count: usize) {
        self.0.store(count.max(1), Ordering::Relaxed);
    }
}

/// Why a work did not finish.
#[derive(Debug, thiserror::Error)]
pub enum WorkError {
    /// The user wanted to stop; the scratch folder holds what is needed to go on.
    #[error("interrupted")]
    Interrupted,
    /// It cannot be done.
    #[error("{message}")]
    Failed {
        /// The diagnostic's code (`R0001`), when there is one.
        code: Option<&'static str>,
        /// What happened.
        message: String,
        /// What to do about it.
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
                let help = match engine {
                    "mujoco" if cfg!(feature = "mujoco") => {
                        "fetch it with `make native` in specforge's folder, or name the library's file in \
                         the variable \
                         SPECFORGE_MUJOCO; `specforge doctor` says what is missing"
                    }
                    _ => "`specforge doctor` says what is missing",
                };
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

    /// A result with a number that is NaN or infinite.
    pub fn not_finite(file: &str, found: &NotFinite) -> Self {
        let help = "look at what the number is made of: a robot's figures, a reward, a rate; `specforge \
            explain R0007` says more";
        Self::coded("R0007", format!("the result is not finite: {file}: {found}"), help)
    }

    /// A failure of the file system.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        // A full or read-only disk has its own code, whoever meets it.
        match StoreError::writing(path, source) {
            StoreError::Io { path, source } => Self::Io { path, source },
            fault => Self::Store(fault),
        }
    }

    /// The diagnostic's code and what to do, where there is something to say.
    pub fn advice(&self) -> (Option<&'static str>, Option<String>) {
        match self {
            Self::Failed { code, help, .. } => (*code, help.clone()),
            Self::Store(fault) => (fault.code(), fault.help().map(Into::into)),
            Self::Interrupted | Self::Io { .. } => (None, None),
        }
    }
}

/// A stage that failed, as a report tells it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The stage's name for people.
    pub stage: String,
    /// The arms that wanted it.
    pub arms: Vec<String>,
    /// The diagnostic's code, when there is one.
    pub code: Option<String>,
    /// What happened.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_engine_that_is_missing_is_r0005_and_sends_to_the_doctor() {
        let missing = crate::sim::open("bullet").err().expect("there is no such engine");
        let (code, help) = WorkError::from(missing).advice();
        assert_eq!((code, help.as_deref()), (Some("R0005"), Some("`specforge doctor` says what is missing")));
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
