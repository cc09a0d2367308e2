//! Collects the input of a report: the plan's records of the arms and the artefacts in the store.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::model::{Arm, Failure, Measured, Policy, ReportInput, StageRecord, Update};
use super::paths::Paths;
use super::request::Request;
use super::{baseline, crossing};
use crate::bounded;
use crate::deploy::policy;
use crate::exec::manifest::{self, Manifest};
use crate::exec::{Job, WorkError};
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::{self, last_push};
use crate::kinds::fine_tune::FineTuning;
use crate::learn::finding::Finding;
use crate::plan::graph::{ArmRecord, Plan};
use crate::plan::{BASELINES, StageKind, TUNED_ENV, Training, replaced};
use crate::spec::section::Report;
use crate::spec::typed::{InSection, Key};
use crate::spec::{Section, Table, Value};

/// Describes the low-level control law of a decoded spec in words.
pub type Law = fn(&Table) -> Option<String>;

/// The input of the report that a job renders.
pub fn gather(job: &Job, law: Law) -> Result<ReportInput, WorkError> {
    let mut arms = job.plan.arms.iter().map(|record| arm(job, record, law)).collect::<Result<Vec<_>, _>>()?;
    let baselines = baselines(job.fields);
    for arm in &mut arms {
        arm.baseline = baseline::choice(&baselines, &arm.fields);
        arm.budget_share =
            arm.baseline.and_then(|place| baseline::budget_share(&baselines[place], &arm.fields));
    }
    let text = |path: &[&str]| text_at(job.fields, path).unwrap_or_default();
    let name = job.stage.users.first().map_or_else(|| text(&["name"]), |user| user.arm.clone());
    let named = named(job.plan);
    Ok(ReportInput {
        name,
        // A combination of specs on the command line has no summary of its own.
        summary: if named > 1 { each(&arms) } else { text(&["summary"]) },
        request: Request {
            files: arms.iter().take(named).map(|arm| arm.spec.clone()).collect(),
            ..request(job.plan)
        },
        template: Section::new(job.fields).part::<Report>().map(|report| report.template).unwrap_or_default(),
        tool_version: env!("CARGO_PKG_VERSION").to_string(),
        commit: env!("SPECFORGE_COMMIT").to_string(),
        arms,
        suite: job.plan.suite.clone(),
        figures: texts_at(job.fields, Report::figures),
        deviations: texts_at(job.fields, Report::deviations),
        question: Section::new(job.fields).at(Report::question).unwrap_or_default(),
        reasons: texts_at(job.fields, Report::reasons),
        baselines,
    })
}

/// What the command of a plan asks for. All its arms have the same options.
pub fn request(plan: &Plan) -> Request {
    let named = || plan.arms.iter().take(named(plan)).map(|arm| &arm.request);
    let options = plan.arms.first().map(|arm| arm.request.clone()).unwrap_or_default();
    Request {
        files: named().map(|request| request.spec.clone()).collect(),
        specs: named().map(|request| request.place.clone()).collect(),
        profile: options.profile,
        set: options.assignments,
        allow_outside: options.outside,
    }
}

/// How many files the command names: only the suite, or only the first arm if it lists its comparisons, else
/// all arms.
pub fn named(plan: &Plan) -> usize {
    let count = plan.arms.len();
    let compares = plan
        .arms
        .first()
        .is_some_and(|first| Section::new(&first.fields.table()).at(Report::compare).is_some());
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

/// The specs that the arms are compared with.
fn baselines(fields: &Table) -> Vec<Table> {
    match fields.get(BASELINES) {
        Some(Value::List(baselines)) => baselines.iter().filter_map(Value::as_table).cloned().collect(),
        _ => Vec::new(),
    }
}

/// A list of texts in the section `report`.
fn texts_at(fields: &Table, key: Key<Report, Vec<String>>) -> Vec<String> {
    Section::new(fields).at(key).unwrap_or_default()
}

fn text_at(table: &Table, path: &[&str]) -> Option<String> {
    match (table.get(*path.first()?)?, &path[1..]) {
        (Value::Text(text), []) => Some(text.clone()),
        (Value::Table(below), rest) => text_at(below, rest),
        _ => None,
    }
}

fn arm(job: &Job, record: &ArmRecord, law: Law) -> Result<Arm, WorkError> {
    let paths = Paths::of(Path::new(&record.request.spec));
    let folder = |stage: &str| job.inputs.get(&format!("{}/{stage}", record.name)).map(|path| path.as_path());
    let fields = record.fields.table();
    let mut arm = Arm {
        name: record.name.clone(),
        summary: text_at(&fields, &["summary"]).unwrap_or_default(),
        spec: paths.shown(&record.request.spec),
        law: law(&fields).unwrap_or_default(),
        fields,
        origins: record.origins.iter().map(|(path, origin)| (path.clone(), paths.origin(origin))).collect(),
        robot: artefact(folder("robot"), "robot.json")?,
        motion: artefact(folder("motion"), "motion.json")?,
        updates: updates(folder(Training::First.stage()))?,
        fine_tuning: updates(folder(Training::FineTuning.stage()))?,
        findings: findings(folder)?,
        baseline: None,
        budget_share: None,
        allow: record.allow.clone(),
        pretrain: artefact(folder("pretrain"), "pretrain.json")?,
        stages: stages(job, record)?,
        failures: failures(job, record, &paths),
        policies: policies(job, record)?,
        evaluations: Vec::new(),
        run: record.run.clone(),
    };
    for kind in [StageKind::Evaluate, StageKind::Transfer] {
        for (stage, key) in &record.stages {
            if job.plan.stage(key).is_some_and(|node| node.kind == kind)
                && let Some(evaluation) = artefact(folder(stage), "evaluation.json")?
            {
                arm.evaluations.push(Measured { stage: stage.clone(), evaluation });
            }
        }
    }
    schedule_pushes(&mut arm);
    arm.evaluations.sort_by(|one, other| order(&one.stage).cmp(&order(&other.stage)));
    crossing::forget(&mut arm);
    Ok(arm)
}

/// The exported policies of an arm, without those of a suite's runs, to which no page links.
fn policies(job: &Job, record: &ArmRecord) -> Result<Vec<Policy>, WorkError> {
    let mut found = Vec::new();
    for (stage, key) in record.stages.iter().filter(|_| job.plan.suite.is_none()) {
        let is_export = job.plan.stage(key).is_some_and(|node| node.kind == StageKind::Export);
        let folder = job.inputs.get(&format!("{}/{stage}", record.name)).filter(|_| is_export);
        let Some(path) = folder.map(|folder| folder.join(policy::FILE)) else { continue };
        match bounded::bytes(&path, bounded::RECORD) {
            Ok(bytes) => found.push(Policy { stage: stage.clone(), bytes }),
            Err(error) if error.is_absence() => {}
            Err(error) => return Err(WorkError::io(&path, error.into())),
        }
    }
    Ok(found)
}

/// Adds the times of scheduled pushes to the evaluations.
fn schedule_pushes(arm: &mut Arm) {
    let spec = Section::new(&arm.fields);
    for measured in &mut arm.evaluations {
        let path = measured.stage.split_once('.');
        let protocol = path.and_then(|(section, name)| spec.section(section)?.section(name));
        measured.evaluation.push = protocol.and_then(|protocol| last_push(spec, protocol));
    }
}

/// Sort key of evaluations: the nominal one comes first, transfers come last.
fn order(stage: &str) -> (bool, bool, Vec<(&str, u64)>) {
    let transferred = stage.split_once('.').is_some_and(|(section, _)| section == Deployment::SECTION);
    (stage != evaluate::nominal(), transferred, natural(stage))
}

/// Splits a name into texts and the numbers after them, so that `load_5` sorts before `load_10`.
fn natural(name: &str) -> Vec<(&str, u64)> {
    let is_digit = |character: char| character.is_ascii_digit();
    let (mut parts, mut rest) = (Vec::new(), name);
    while !rest.is_empty() {
        let (text, behind) = rest.split_at(rest.find(is_digit).unwrap_or(rest.len()));
        let digits = behind.find(|character| !is_digit(character)).unwrap_or(behind.len());
        parts.push((text, if digits == 0 { 0 } else { behind[..digits].parse().unwrap_or(u64::MAX) }));
        rest = &behind[digits..];
    }
    parts
}

/// Findings of the run-time checks in both trainings; those in the fine-tuning say so.
fn findings<'a>(folder: impl Fn(&str) -> Option<&'a Path>) -> Result<Option<Vec<Finding>>, WorkError> {
    let of = |training: Training| -> Result<Option<Vec<Finding>>, WorkError> {
        let summary = artefact::<Findings>(folder(training.stage()), "summary.json")?;
        Ok(summary.and_then(|summary| summary.warnings))
    };
    let (first, tuning) = (of(Training::First)?, of(Training::FineTuning)?);
    let tuning = tuning.map(|found| {
        let told =
            |found: Finding| Finding { message: format!("in the fine-tuning: {}", found.message), ..found };
        found.into_iter().map(told).collect::<Vec<_>>()
    });
    Ok(match (first, tuning) {
        (Some(first), Some(tuning)) => Some([first, tuning].concat()),
        (first, tuning) => first.or(tuning),
    })
}

/// The part of `summary.json` that a report uses.
#[derive(serde::Deserialize)]
struct Findings {
    #[serde(default)]
    warnings: Option<Vec<Finding>>,
}

/// A JSON file of an artefact; `None` if the artefact or the file is missing.
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
    match bounded::text(&path, bounded::RECORD) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.is_absence() => Ok(None),
        Err(error) => Err(WorkError::io(&path, error.into())),
    }
}

/// The stages of an arm that are in the store, in plan order.
fn stages(job: &Job, record: &ArmRecord) -> Result<Vec<StageRecord>, WorkError> {
    let mut records = Vec::new();
    let fields = record.fields.table();
    for node in job.plan.stages() {
        for (stage, _) in record.stages.iter().filter(|(_, key)| **key == node.fingerprint) {
            let folder = job.inputs.get(&format!("{}/{stage}", record.name)).map(|path| path.as_path());
            let Some(text) = text_file(folder, manifest::FILE)? else { continue };
            let manifest = Manifest::from_text(&text).map_err(WorkError::failed)?;
            let inputs = node.recipe.inputs.values().filter_map(|input| {
                record.stages.iter().find(|(_, key)| *key == input).map(|(name, _)| name.clone())
            });
            records.push(StageRecord {
                stage: stage.clone(),
                fingerprint: node.fingerprint.to_string(),
                fields: spec_fields(node.kind, stage, &fields),
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

/// The declared fields of a stage as paths in the spec: `evaluate` of the stage `evaluate.nominal` is that
/// table, and the environment of a fine-tuning has some keys of its own.
fn spec_fields(kind: StageKind, stage: &str, spec: &Table) -> Vec<String> {
    let declared = kind.facts().fields.iter();
    match kind {
        StageKind::Evaluate | StageKind::Export | StageKind::Transfer => {
            declared.map(|_| stage.to_owned()).collect()
        }
        StageKind::Env if stage == TUNED_ENV => {
            let own = tuned(spec);
            declared.flat_map(|field| spelled(&field.path(), spec.get(&field.path()), &own)).collect()
        }
        _ => declared.map(|field| field.path()).collect(),
    }
}

/// The keys with which a fine-tuning replaces values of the first training's environment, by the replaced
/// path.
fn tuned(spec: &Table) -> BTreeMap<String, String> {
    Section::new(spec).within::<FineTuning>().map(replaced).into_iter().flatten().collect()
}

/// Converts a path of the first training's environment to paths for the fine-tuning: a replaced value becomes
/// the key that replaces it, and a table with a replaced value is split into its values.
fn spelled(path: &str, value: Option<&Value>, own: &BTreeMap<String, String>) -> Vec<String> {
    let below = format!("{path}.");
    match (own.get(path), value) {
        (Some(key), _) => vec![key.clone()],
        (None, Some(Value::Table(table))) if own.keys().any(|place| place.starts_with(&below)) => table
            .iter()
            .flat_map(|(key, value)| spelled(&format!("{below}{key}"), Some(value), own))
            .collect(),
        _ => vec![path.to_owned()],
    }
}

/// The failures; if nothing failed, the first stage that has not been run.
fn failures(job: &Job, record: &ArmRecord, paths: &Paths) -> Vec<Failure> {
    let of_arm = job.failures.iter().filter(|failure| failure.arms.contains(&record.name));
    let failed: Vec<Failure> = of_arm
        .map(|failure| {
            let code = failure.code.as_ref().map_or(String::new(), |code| format!("[{code}] "));
            let reason = format!("{code}{}", paths.message(failure.message.trim_end_matches('.')));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn table<const N: usize>(entries: [(&str, Value); N]) -> Value {
        Value::Table(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
    }

    #[test]
    fn evaluations_come_in_the_order_of_their_numbers() {
        let mut stages =
            ["deploy.mujoco", "evaluate.load_10", "evaluate.load_5", "evaluate.flat", "evaluate.nominal"];
        stages.sort_by(|one, other| order(one).cmp(&order(other)));
        let sorted =
            ["evaluate.nominal", "evaluate.flat", "evaluate.load_5", "evaluate.load_10", "deploy.mujoco"];
        assert_eq!(stages, sorted);
    }

    #[test]
    fn the_world_of_a_fine_tuning_is_read_from_its_own_keys() {
        let term = || table([("k", Value::Count(3)), ("weight", Value::Count(1))]);
        let ground = || table([("kind", Value::Text("flat".into()))]);
        let weights = table([("torque", Value::Count(2))]);
        let spec = table([
            ("reward", table([("torque", term()), ("contact_force", term())])),
            ("physics", table([("engine", Value::Text("rapier".into())), ("rate", Value::Count(500))])),
            ("terrain", ground()),
            (
                "fine_tune",
                table([
                    ("terrain", ground()),
                    ("engine", Value::Text("mujoco".into())),
                    ("weights", weights),
                ]),
            ),
        ]);
        let Value::Table(spec) = spec else { panic!("a table") };
        let read = spec_fields(StageKind::Env, TUNED_ENV, &spec);
        for path in [
            "reward.torque.k",
            "fine_tune.weights.torque",
            "reward.contact_force",
            "fine_tune.engine",
            "physics.rate",
            "fine_tune.terrain",
            "action",
        ] {
            assert!(read.iter().any(|own| own == path), "{path} is not in {read:?}");
        }
        let replaced =
            ["reward", "reward.torque.weight", "physics", "physics.engine", "terrain", "fine_tune.std"];
        assert!(!read.iter().any(|own| replaced.contains(&own.as_str())), "{read:?}");
        assert!(spec_fields(StageKind::Env, "env", &spec).contains(&"reward".to_owned()));
        assert_eq!(spec_fields(StageKind::Evaluate, "evaluate.nominal", &spec), ["evaluate.nominal"]);
    }
}
