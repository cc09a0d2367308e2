//! What happens during a run, as events: JSON lines for programs, the source of progress for people.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use crate::escape::terminal;

/// An event of a run. Serialised it is one line of `run --format json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// A stage begins.
    StageStarted {
        /// Its name.
        stage: String,
        /// Its key.
        key: String,
        /// Its kind.
        kind: String,
        /// Why it runs, one line per reason.
        reasons: Vec<String>,
    },
    /// How far a stage is.
    Progress {
        /// Its name.
        stage: String,
        /// What is done, in the unit.
        done: u64,
        /// What there is to do.
        total: u64,
        /// What is counted: `samples`, `episodes`.
        unit: String,
        /// A short remark, for example the return.
        #[serde(skip_serializing_if = "String::is_empty", default)]
        note: String,
    },
    /// Numbers that a stage measured, for example one learner update.
    Metric {
        /// Its name.
        stage: String,
        /// Numbers by name.
        values: BTreeMap<String, f64>,
    },
    /// A stage has its artefact.
    StageFinished {
        /// Its name.
        stage: String,
        /// Its key.
        key: String,
        /// Whether it was there already.
        cached: bool,
        /// Wall time in s.
        wall_s: f64,
    },
    /// A stage has no artefact.
    StageFailed {
        /// Its name.
        stage: String,
        /// Its key.
        key: String,
        /// The diagnostic's code, when there is one.
        code: Option<String>,
        /// What happened.
        message: String,
        /// What to do about it.
        help: Option<String>,
    },
    /// Something that the user should know and that stops nothing.
    Warning {
        /// The stage that it is about, when it is about one.
        #[serde(skip_serializing_if = "Option::is_none", default)]
        stage: Option<String>,
        /// The diagnostic's code, when there is one.
        code: Option<String>,
        /// What it is.
        message: String,
        /// What to do about it.
        #[serde(skip_serializing_if = "Option::is_none", default)]
        help: Option<String>,
    },
    /// Something that happens as it should and that explains what follows.
    Note {
        /// The stage that it is about.
        stage: String,
        /// What it is.
        message: String,
    },
    /// The run is over.
    RunFinished {
        /// `ok`, `failed`, `interrupted` or `crashed`: a library ended the process.
        outcome: String,
        /// The report, when there is one.
        report: Option<String>,
        /// Stages that were worked on.
        worked: usize,
        /// Stages that were cached.
        cached: usize,
        /// Stages that failed or could not start.
        failed: usize,
        /// The arms that fail their task in some evaluation: arm, evaluation, policies, how many of them
        /// fail, and why.
        #[serde(default)]
        failing_arms: Vec<serde_json::Value>,
        /// Claims with their outcome.
        claims: Vec<serde_json::Value>,
        /// Wall time in s.
        wall_s: f64,
    },
}

/// Takes events. Called from the threads of the works.
pub trait Events: Send + Sync {
    /// Takes one.
    fn emit(&self, event: Event);
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silence;

impl Events for Silence {
    fn emit(&self, _: Event) {}
}

/// Writes one JSON object per line.
pub struct JsonLines<W>(Mutex<W>);

impl<W: Write> JsonLines<W> {
    /// Writes to this stream.
    pub fn new(stream: W) -> Self {
        Self(Mutex::new(stream))
    }
}

impl<W: Write + Send> Events for JsonLines<W> {
    fn emit(&self, event: Event) {
        let line = serde_json::to_string(&event).expect("an event is plain data");
        let mut stream = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // A reader that went away is no reason to stop a training.
        let _ = writeln!(stream, "{}", terminal::line(&line)).and_then(|()| stream.flush());
    }
}

/// Keeps events, for tests and summaries.
#[derive(Debug, Default)]
pub struct Record(Mutex<Vec<Event>>);

impl Record {
    /// The events so far.
    pub fn events(&self) -> Vec<Event> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()
    }
}

impl Events for Record {
    fn emit(&self, event: Event) {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(event);
    }
}
