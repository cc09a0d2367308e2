//! The content of a report: arms, their training, their evaluations and the provenance of each.
//!
//! Plain data that `exec` reads from the store; independent of folders, templates and figures.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::request::Request;
use crate::kinds::action::Position;
use crate::kinds::motion::Motion;
use crate::kinds::task::{self, Meaning, Task};
use crate::learn::finding::Finding;
use crate::outcome::Evaluation;
use crate::plan::{RunRecord, SuiteRecord, Training};
use crate::robot::Robot;
use crate::spec::typed::InSection;
use crate::spec::{Section, Table};

/// The input from which a report is rendered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReportInput {
    /// Name of the spec; the report is `reports/NAME.md`.
    pub name: String,
    /// The spec's one-line summary.
    pub summary: String,
    /// The files and options of the command that regenerates the report.
    pub request: Request,
    /// Name of the template, for example `report.md.j2`.
    pub template: String,
    /// Version of specforge that renders the report.
    pub tool_version: String,
    /// Its commit.
    pub commit: String,
    /// The arms, the spec's own first; for a suite its runs, grouped by arm.
    pub arms: Vec<Arm>,
    /// The suite, for a report on a suite.
    #[serde(default)]
    pub suite: Option<SuiteRecord>,
    /// The requested figures; all if empty.
    #[serde(default)]
    pub figures: Vec<String>,
    /// The spec's declared deviations from the experiment that it reproduces.
    #[serde(default)]
    pub deviations: Vec<String>,
    /// The question that the spec says the report answers; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub question: String,
    /// Why the result may differ from the paper's, in the spec's sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<String>,
    /// The specs that the arms are compared with, resolved; each arm has the index of its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub baselines: Vec<Table>,
}

/// One arm of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Name of its spec.
    pub name: String,
    /// One-line summary of its spec.
    pub summary: String,
    /// Its file as the user named it.
    pub spec: String,
    /// The low-level control law in one line; empty if unknown.
    #[serde(default)]
    pub law: String,
    /// The decoded spec.
    pub fields: Table,
    /// The origin of each value, by path (`learn.samples` -> `specs/base/task/run.toml:12`).
    #[serde(default)]
    pub origins: BTreeMap<String, String>,
    /// The robot; absent if its stage failed.
    #[serde(default)]
    pub robot: Option<Robot>,
    /// The reference motion, if any.
    #[serde(default)]
    pub motion: Option<Motion>,
    /// The learner's metrics, one entry per update, from `metrics.jsonl`.
    #[serde(default)]
    pub updates: Vec<Update>,
    /// The same for the fine-tuning, if any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fine_tuning: Vec<Update>,
    /// Findings of the run-time checks in the trainings, from `summary.json`; `None` if nothing was trained
    /// or nothing was checked.
    #[serde(default)]
    pub findings: Option<Vec<Finding>>,
    /// The warnings that the spec allows, with their reasons.
    #[serde(default)]
    pub allow: BTreeMap<String, String>,
    /// Pre-training, from `pretrain.json`.
    #[serde(default)]
    pub pretrain: Option<Pretrain>,
    /// Evaluations, in the order of the report's columns.
    #[serde(default)]
    pub evaluations: Vec<Measured>,
    /// The stages that were run, or found in the store.
    #[serde(default)]
    pub stages: Vec<StageRecord>,
    /// Its exported policies, for copies beside the page; none for the runs of a suite.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub policies: Vec<Policy>,
    /// Stages that failed.
    #[serde(default)]
    pub failures: Vec<Failure>,
    /// The run's place in its suite, for a run of a suite.
    #[serde(default)]
    pub run: Option<RunRecord>,
    /// Index of the baseline that it is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<usize>,
    /// Its number of samples as a share of the baseline's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget_share: Option<f64>,
}

/// An evaluation and its stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The stage: `evaluate.nominal`, `deploy.mujoco`.
    pub stage: String,
    /// The measurements.
    pub evaluation: Evaluation,
}

/// The learner's metrics of one update: a line of `metrics.jsonl`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Update {
    /// Index of the update.
    pub update: u64,
    /// Samples so far.
    pub samples: u64,
    /// Simulated time so far in s.
    pub simulated_s: f64,
    /// Wall time so far in s.
    pub wall_s: f64,
    /// CPU time so far in s.
    pub cpu_s: f64,
    /// Mean return of the episodes that ended in this update.
    pub return_mean: Option<f64>,
    /// Mean length of the episodes that ended in this update, in s.
    pub length_mean_s: Option<f64>,
    /// Share of the control steps in which exactly one foot touches the ground.
    pub single_support: Option<f64>,
    /// Mean KL divergence of the update.
    pub kl: Option<f64>,
    /// Share of the samples with a clipped probability ratio.
    pub clip_fraction: Option<f64>,
    /// Share of the returns' variance explained by the critic.
    pub explained_variance: Option<f64>,
    /// The actor's learning rate.
    pub learning_rate: Option<f64>,
    /// Samples per second of wall time.
    pub samples_per_s: Option<f64>,
    /// Mean of each reward term per step.
    pub terms: BTreeMap<String, f64>,
    /// Number of episodes by cause of termination.
    pub ends: BTreeMap<String, u64>,
}

/// Result of the pre-training: `pretrain.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Pretrain {
    /// Root mean square error of the predicted torques in N m.
    pub rmse_nm: f64,
    /// Root mean square of the torques themselves in N m: the error of a network whose output is zero.
    pub label_rms_nm: f64,
    /// Number of labelled samples.
    pub samples: u64,
    /// CPU time in s.
    pub cpu_s: f64,
}

/// A stage's entry in the store.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StageRecord {
    /// Its name in the arm: `learner`, `evaluate.nominal`.
    pub stage: String,
    /// The fingerprint.
    pub fingerprint: String,
    /// The spec fields that it reads, as paths of tables or keys.
    pub fields: Vec<String>,
    /// Stages of the same arm whose artefacts it reads.
    pub inputs: Vec<String>,
    /// Version of specforge that ran it.
    pub tool_version: String,
    /// Commit of specforge that ran it.
    pub commit: String,
    /// Wall time in s.
    pub wall_s: f64,
    /// CPU time in s.
    pub cpu_s: f64,
    /// When it ended, as `2026-01-31 12:00 UTC`; empty when not recorded.
    pub finished: String,
}

/// A policy exported by an arm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Policy {
    /// The stage that exported it.
    pub stage: String,
    /// The content of its file.
    #[serde(skip)]
    pub bytes: Vec<u8>,
}

/// A stage that failed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Its name in the arm.
    pub stage: String,
    /// The message.
    pub reason: String,
}

impl Update {
    /// The lines of `metrics.jsonl`.
    pub fn parse_lines(text: &str) -> Result<Vec<Self>, serde_json::Error> {
        text.lines().filter(|line| !line.trim().is_empty()).map(serde_json::from_str).collect()
    }
}

impl Measured {
    /// Whether it is the same stage in the same engine, for another arm.
    pub fn is_the_same_as(&self, other: &Self) -> bool {
        self.stage == other.stage && self.evaluation.engine == other.evaluation.engine
    }
}

impl Arm {
    /// The decoded spec as a section.
    pub fn section(&self) -> Section<'_> {
        Section::new(&self.fields)
    }

    /// The metrics of one of its trainings.
    pub fn updates_of(&self, training: Training) -> &[Update] {
        match training {
            Training::First => &self.updates,
            Training::FineTuning => &self.fine_tuning,
        }
    }

    /// The kind of a section, or an empty text.
    pub fn kind<Part: InSection>(&self) -> &str {
        self.section().within::<Part>().and_then(|table| table.kind()).unwrap_or("")
    }

    /// The engine of one of its evaluations, or the stage if it has several in that engine.
    pub fn place_of<'a>(&self, measured: &'a Measured) -> &'a str {
        let engine = &measured.evaluation.engine;
        let twins = self.evaluations.iter().filter(|other| other.evaluation.engine == *engine).count();
        if twins > 1 { &measured.stage } else { engine }
    }

    /// What its task requires; `None` for an unknown task.
    pub fn task(&self) -> Option<&'static Meaning> {
        task::meaning(self.kind::<Task>())
    }

    /// Whether the robot travels in its task.
    pub fn travels(&self) -> bool {
        self.task().is_some_and(|task| task.travels)
    }

    /// The record of a stage.
    pub fn stage(&self, name: &str) -> Option<&StageRecord> {
        self.stages.iter().find(|record| record.stage == name)
    }

    /// Rate of the policy in Hz.
    pub fn control_rate(&self) -> Option<f64> {
        self.section().at(Position::rate)
    }
}
