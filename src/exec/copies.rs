//! Checks files of an artefact that duplicate its stage or another of its files against their source.
//!
//! Not checked: a motion, which would have to be rebuilt, and `controller.json`, `robot.xml` and the
//! TensorBoard events, which no stage reads.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::manifest::Depth;
use super::works::robot;
use crate::bounded;
use crate::deploy::policy;
use crate::learn::file;
use crate::plan::fingerprint::canonical_json;
use crate::plan::{Stage, StageKind};
use crate::robot::Robot;
use crate::spec::Table;

/// Fails with the name of the first file in a stage's folder that contradicts its source.
pub fn check(folder: &Path, stage: &Stage, depth: Depth) -> Result<(), String> {
    match (stage.kind, depth) {
        (StageKind::Export, _) => contract(folder),
        (StageKind::Learner | StageKind::FineTune, _) => summary(folder),
        (StageKind::Robot, Depth::Full) => model(folder, stage),
        (StageKind::Env, Depth::Full) => environment(folder, stage),
        _ => Ok(()),
    }
}

/// Reads a JSON file of the artefact; `None` if the artefact does not have it.
fn json<T: DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<T>, String> {
    let path = folder.join(name);
    if !path.exists() {
        return Ok(None);
    }
    let text = bounded::text(&path, bounded::RECORD).map_err(|error| format!("{name}: {error}"))?;
    serde_json::from_str(&text).map(Some).map_err(|error| format!("{name}: {error}"))
}

fn same(one: &Value, other: &Value) -> bool {
    canonical_json(one) == canonical_json(other)
}

/// The contract next to the policy duplicates the one inside, for readers that cannot read tensors.
fn contract(folder: &Path) -> Result<(), String> {
    let (Some(copy), Ok(bytes)) = (
        json::<Value>(folder, "contract.json")?,
        bounded::bytes(&folder.join(policy::FILE), bounded::ARTEFACT),
    ) else {
        return Ok(());
    };
    let header = file::header(&bytes).map_err(|error| format!("policy.safetensors: {error}"))?;
    let own = header.get("contract").and_then(|text| serde_json::from_str::<Value>(text).ok());
    let agrees = own.is_some_and(|own| same(&own, &copy));
    if agrees { Ok(()) } else { Err("contract.json is not the contract of policy.safetensors".into()) }
}

/// The summary of a training repeats its last metrics.
fn summary(folder: &Path) -> Result<(), String> {
    let Some(summary) = json::<Value>(folder, "summary.json")? else { return Ok(()) };
    let text = bounded::text(&folder.join("metrics.jsonl"), bounded::RECORD)
        .map_err(|error| format!("metrics.jsonl: {error}"))?;
    let wrong = |what: &str| Err(format!("summary.json says other {what} than metrics.jsonl"));
    if summary["updates"].as_u64() != Some(text.lines().count() as u64) {
        return wrong("updates");
    }
    let update = |line: &str| serde_json::from_str::<Value>(line).ok();
    let last = text.lines().next_back().and_then(update).unwrap_or_default();
    if !text.is_empty() && summary["samples"] != last["samples"] {
        return wrong("samples");
    }
    let ended = text.lines().rev().filter_map(update).find(|line| line["episodes"].as_u64() > Some(0));
    let ended = ended.unwrap_or_default();
    match ["return_mean", "length_mean_s"].into_iter().find(|name| !same(&summary[*name], &ended[*name])) {
        Some(name) => wrong(&format!("`{name}`")),
        None => Ok(()),
    }
}

/// The model must be that of the recipe, with its payload.
fn model(folder: &Path, stage: &Stage) -> Result<(), String> {
    let Some(copy) = json::<Robot>(folder, "robot.json")? else { return Ok(()) };
    let value = |robot: &Robot| serde_json::to_value(robot).unwrap_or_default();
    let own = robot::resolved(&stage.recipe.content, &stage.fields).map_err(|error| error.to_string())?;
    let agrees = same(&value(&own), &value(&copy));
    if agrees { Ok(()) } else { Err("robot.json is not the robot of its stage".into()) }
}

/// The fields of a blueprint.
#[derive(serde::Deserialize)]
struct Fields {
    fields: Table,
}

/// The blueprint must be built from the stage's fields.
fn environment(folder: &Path, stage: &Stage) -> Result<(), String> {
    let Some(Fields { fields }) = json(folder, "env.json")? else { return Ok(()) };
    let copy = Stage { fields: fields.into(), ..stage.clone() };
    copy.hidden_field().map_or(Ok(()), |path| Err(format!("env.json: `{path}` is not that of its stage")))
}
