//! Gathers what a report is rendered from: the plan's records of the arms and the artefacts in the store.

use std::path::Path;

use serde::de::DeserializeOwned;

use super::model::{Arm, Failure, Measured, ReportInput, StageRecord, Update};
use crate::exec::manifest::{self, Manifest};
use crate::exec::{Job, WorkError};
use crate::learn::health::Finding;
use crate::plan::graph::{ArmRecord, Plan};
use crate::plan::{StageKind, TUNED_ENV, Training};
use crate::spec::{Section, Table, Value};

/// The low-level law of a decoded spec in words.
pub type Law = fn(&Table) -> Option<String>;

/// The input of the report that a job is to render.
pub fn gather(job: &Job, law: Law) -> Result<ReportInput, WorkError> {
    let arms = job.plan.arms.iter().map(|record| arm(job, record, law)).collect::<Result<Vec<_>, _>>()?;
    let text = |path: &[&str]| text_at(job.fields, path).unwrap_or_default();
    let request = job.plan.arms.first().map(|record| record.request.clone()).unwrap_or_default();
    let name = job.stage.users.first().map_or_else(|| text(&["name"]), |user| user.arm.clone());
    let named = named(job.plan, arms.len());
    Ok(ReportInput {
        name,
        // What was put together on the command line has no summary of its own.
        summary: if named > 1 { each(&arms) } else { text(&["summary"]) },
        specs: job.plan.arms.iter().take(named).map(|arm| arm.request.spec.clone()).collect(),
        profile: request.profile,
        assignments: request.assignments,
        template: text_at(job.fields, &["report", "template"]).unwrap_or_else(|| "run.md.j2".to_string()),
        tool_version: env!("CARGO_PKG_VERSION").to_string(),
        commit: env!("SPECFORGE_COMMIT").to_string(),
        arms,
        suite: job.plan.suite.clone(),
        figures: texts_at(job.fields, "figures"),
        deviations: texts_at(job.fields, "deviations"),
    })
}

/// How many files a user names to run this again: the suite, the first arm's, which names what it is compared with,
/// or all when no spec does.
fn named(plan: &Plan, count: usize) -> usize {
    let compares = plan.arms.first().is_some_and(|first| match first.fields.get("report") {
        Some(Value::Table(report)) => report.contains_key("compare"),
        _ => false,
    });
    if plan.suite.is_some() || compares { count.min(1) } else { count }
}

/// The summaries of all arms, in one line.
fn each(arms: &[Arm]) -> String {
    let each = |arm: &Arm| match arm.summary.trim_end_matches('.') {
        "" => format!("`{}`", arm.name),
        summary => format!("`{}`: {summary}", arm.name),
    };
    arms.iter().map(each).collect::<Vec<_>>().join("; ")
}

/// A list of texts in the section `report`.
fn texts_at(fields: &Table, key: &str) -> Vec<String> {
    match fields.get("report") {
        Some(Value::Table(report)) => Section::new(report).texts(key),
        _ => Vec::new(),
    }
}

fn text_at(table: &Table, path: &[&str]) -> Option<String> {
    match (table.get(*path.first()?)?, &path[1..]) {
        (Value::Text(text), []) => Some(text.clone()),
        (Value::Table(below), rest) => text_at(below, rest),
        _ => None,
    }
}

fn arm(job: &Job, record: &ArmRecord, law: Law) -> Result<Arm, WorkError> {
    let folder = |stage: &str| job.inputs.get(&format!("{}/{stage}", record.name)).map(|path| path.as_path());
    let mut arm = Arm {
        name: record.name.clone(),
        summary: text_at(&record.fields, &["summary"]).unwrap_or_default(),
        spec: record.request.spec.clone(),
        law: law(&record.fields).unwrap_or_default(),
        fields: record.fields.clone(),
        origins: (*record.origins).clone(),
        robot: artefact(folder("robot"), "robot.json")?,
        motion: artefact(folder("motion"), "motion.json")?,
        updates: updates(folder(Training::First.stage()))?,
        fine_tuning: updates(folder(Training::FineTuning.stage()))?,
        findings: findings(folder)?,
        allow: record.allow.clone(),
        pretrain: artefact(folder("pretrain"), "pretrain.json")?,
        stages: stages(job, record)?,
        failures: failures(job, record),
        evaluations: Vec::new(),
        run: record.run.clone(),
    };
    // Evaluations come first, before them the one that the task asks for; then transfers to other engines.
    for kind in [StageKind::Evaluate, StageKind::Transfer] {
        for (stage, key) in &record.stages {
            if job.plan.stage(key).is_some_and(|node| node.kind == kind)
                && let Some(evaluation) = artefact(folder(stage), "evaluation.json")?
            {
                arm.evaluations.push(Measured { stage: stage.clone(), evaluation });
            }
        }
    }
    arm.evaluations.sort_by_key(|measured| measured.stage != "evaluate.nominal");
    Ok(arm)
}

/// What the checks of both trainings found; of the fine-tuning it is said that it is its.
fn findings<'a>(folder: impl Fn(&str) -> Option<&'a Path>) -> Result<Option<Vec<Finding>>, WorkError> {
    let of = |training: Training| -> Result<Option<Vec<Finding>>, WorkError> {
        let summary = artefact::<Findings>(folder(training.stage()), "summary.json")?;
        Ok(summary.and_then(|summary| summary.warnings))
    };
    let (first, tuning) = (of(Training::First)?, of(Training::FineTuning)?);
    let tuning = tuning.map(|found| {
        let told = |found: Finding| Finding { message: format!("in the fine-tuning: {}", found.message), ..found };
        found.into_iter().map(told).collect::<Vec<_>>()
    });
    Ok(match (first, tuning) {
        (Some(first), Some(tuning)) => Some([first, tuning].concat()),
        (first, tuning) => first.or(tuning),
    })
}

/// What a report reads of `summary.json`.
#[derive(serde::Deserialize)]
struct Findings {
    #[serde(default)]
    warnings: Option<Vec<Finding>>,
}

/// A JSON file of an artefact; `None` when the artefact or the file is not there.
fn artefact<T: DeserializeOwned>(folder: Option<&Path>, file: &str) -> Result<Option<T>, WorkError> {
    let Some(text) = text_file(folder, file)? else { return Ok(None) };
    serde_json::from_str(&text).map(Some).map_err(|error| WorkError::failed(format!("{file}: {error}")))
}

fn updates(folder: Option<&Path>) -> Result<Vec<Update>, WorkError> {
    let text = text_file(folder, "metrics.jsonl")?.unwrap_or_default();
    Update::parse_lines(&text).map_err(|error| WorkError::failed(format!("metrics.jsonl: {error}")))
}

fn text_file(folder: Option<&Path>, file: &str) -> Result<Option<String>, WorkError> {
    let Some(path) = folder.map(|folder| folder.join(file)) else { return Ok(None) };
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(WorkError::io(&path, error)),
    }
}

/// The stages of an arm that are in the store, in the order of the plan.
fn stages(job: &Job, record: &ArmRecord) -> Result<Vec<StageRecord>, WorkError> {
    let mut records = Vec::new();
    for node in job.plan.stages() {
        for (stage, _) in record.stages.iter().filter(|(_, key)| **key == node.fingerprint) {
            let folder = job.inputs.get(&format!("{}/{stage}", record.name)).map(|path| path.as_path());
            let Some(text) = text_file(folder, manifest::FILE)? else { continue };
            let manifest = Manifest::from_text(&text).map_err(WorkError::failed)?;
            let declared = node.kind.facts().fields.iter();
            let inputs =
                node.recipe.inputs.values().filter_map(|input| {
                    record.stages.iter().find(|(_, key)| *key == input).map(|(name, _)| name.clone())
                });
            records.push(StageRecord {
                stage: stage.clone(),
                fingerprint: node.fingerprint.to_string(),
                fields: declared.map(|field| spec_field(node.kind, field, stage)).collect(),
                inputs: inputs.collect(),
                tool_version: manifest.provenance.tool,
                commit: manifest.provenance.commit,
                wall_s: manifest.provenance.wall_s,
                cpu_s: manifest.provenance.cpu_s,
                finished: manifest.provenance.finished,
            });
        }
    }
    Ok(records)
}

/// A declared field as a path in the spec: `evaluate` of the stage `evaluate.nominal` is that table.
fn spec_field(kind: StageKind, field: &str, stage: &str) -> String {
    match kind {
        StageKind::Evaluate | StageKind::Export | StageKind::Transfer => stage.to_string(),
        StageKind::Env if stage == TUNED_ENV && field == "terrain" => "fine_tune.terrain".to_string(),
        _ => field.to_string(),
    }
}

/// What failed; without failures, the first stage that nobody has run.
fn failures(job: &Job, record: &ArmRecord) -> Vec<Failure> {
    let of_arm = job.failures.iter().filter(|failure| failure.arms.contains(&record.name));
    let failed: Vec<Failure> = of_arm
        .map(|failure| {
            let code = failure.code.as_ref().map_or(String::new(), |code| format!("[{code}] "));
            let reason = format!("{code}{}", failure.message.trim_end_matches('.'));
            Failure { stage: failure.stage.clone(), reason }
        })
        .collect();
    if !failed.is_empty() {
        return failed;
    }
    let nodes = job.plan.stages().filter(|node| node.users.iter().any(|user| user.arm == record.name));
    let named = nodes.filter_map(|node| record.stages.iter().find(|(_, key)| **key == node.fingerprint));
    let mut absent = named.filter(|(stage, _)| !job.inputs.contains_key(&format!("{}/{stage}", record.name)));
    let first = absent.next().map(|(stage, _)| stage.clone());
    first.map(|stage| Failure { stage, reason: "it has not been run".to_string() }).into_iter().collect()
}
