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
        /// The stage's name for people.
        stage: String,
        /// The stage's fingerprint.
        key: String,
        /// The stage's kind.
        kind: String,
        /// Why it runs, one line per reason.
        reasons: Vec<String>,
    },
    /// The progress of a stage.
    Progress {
        /// The stage's name for people.
        stage: String,
        /// Amount done, in `unit`.
        done: u64,
        /// Total amount, in `unit`.
        total: u64,
        /// What is counted: `samples`, `episodes`.
        unit: String,
        /// A short remark, for example the return.
        #[serde(skip_serializing_if = "String::is_empty", default)]
        note: String,
    },
    /// Numbers that a stage measured, for example one learner update.
    Metric {
        /// The stage's name for people.
        stage: String,
        /// Numbers by name.
        values: BTreeMap<String, f64>,
    },
    /// The artefact of a stage is in the store.
    StageFinished {
        /// The stage's name for people.
        stage: String,
        /// The stage's fingerprint.
        key: String,
        /// Whether the artefact was in the store already.
        cached: bool,
        /// Wall time in s.
        wall_s: f64,
    },
    /// A stage failed.
    StageFailed {
        /// The stage's name for people.
        stage: String,
        /// The stage's fingerprint.
        key: String,
        /// The diagnostic's code, if it has one.
        code: Option<String>,
        /// What happened.
        message: String,
        /// How to fix it.
        help: Option<String>,
    },
    /// A problem that does not stop the run.
    Warning {
        /// The stage concerned, if it is about one.
        #[serde(skip_serializing_if = "Option::is_none", default)]
        stage: Option<String>,
        /// The diagnostic's code, if it has one.
        code: Option<String>,
        /// The text of the warning.
        message: String,
        /// How to fix it.
        #[serde(skip_serializing_if = "Option::is_none", default)]
        help: Option<String>,
    },
    /// An expected event that explains what follows.
    Note {
        /// The stage concerned.
        stage: String,
        /// The text of the note.
        message: String,
    },
    /// The run is over.
    RunFinished {
        /// `ok`, `failed`, `interrupted` or `crashed` (a library ended the process).
        outcome: String,
        /// The report, if there is one.
        report: Option<String>,
        /// Stages that ran.
        worked: usize,
        /// Stages that were cached.
        cached: usize,
        /// Stages that failed or could not start.
        failed: usize,
        /// The arms that fail their task in an evaluation: arm, evaluation, number of policies, how many of
        /// them fail, and why.
        #[serde(default)]
        failing_arms: Vec<serde_json::Value>,
        /// The arms of which an evaluation is too short to judge the task: arm, evaluation, number of policies,
        /// how many of them are not judged, and why.
        #[serde(default)]
        unjudged_arms: Vec<serde_json::Value>,
        /// Claims with their outcome.
        claims: Vec<serde_json::Value>,
        /// Wall time in s.
        wall_s: f64,
    },
}

/// A receiver of events, called from the threads of the stages.
pub trait Events: Send + Sync {
    /// Handles one event.
    fn emit(&self, event: Event);
}

/// Discards all events.
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
        // A closed pipe must not stop a training.
        let _ = writeln!(stream, "{}", terminal::line(&line)).and_then(|()| stream.flush());
    }
}

/// Collects events, for tests and summaries.
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
