//! Trainings of which one is the beginning of another: they differ only in `learn.stop_at`. The longer one continues from the
//! final checkpoint of the shorter one if that is in the store, and has the bits of an uninterrupted training either way;
//! so the shorter one is not an input and does not enter the longer one's fingerprint.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::fault::StoreError;
use super::manifest::Depth;
use super::store::Store;
use crate::learn::beside;
use crate::learn::checkpoint::Checkpoint;
use crate::plan::{Cached, Fingerprint, Recipe, Stage, StageKind};
use crate::{bounded, finite, safe_fs};

/// The record of the shorter training, beside the checkpoint and in the artefact of the longer one.
pub const FILE: &str = "continues.json";

/// The training that another one continues.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Its fingerprint.
    pub fingerprint: Fingerprint,
    /// Samples that it was trained with (`learn.stop_at`).
    pub samples: u64,
}

/// Copies the final checkpoint of the longest training of less of the stage's schedule into the stage's scratch folder, with
/// what belongs to it. Does nothing where the folder has a checkpoint, and for stages that are no such training.
pub fn lend(store: &Store, stage: &Stage, scratch: &Path) -> Result<Option<Link>, StoreError> {
    if stage.kind != StageKind::Learner || Checkpoint::path(scratch).exists() {
        return Ok(None);
    }
    let mut found: Vec<Link> = store.keys(stage.kind).into_iter().filter_map(|key| link(store, stage, key)).collect();
    found.sort_by_key(|link| std::cmp::Reverse(link.samples));
    let whole = |link: &Link| matches!(store.inspect(stage.kind, &link.fingerprint, Depth::Full), Cached::Yes);
    let Some(link) = found.into_iter().find(whole) else { return Ok(None) };
    let from = store.folder(stage.kind, &link.fingerprint);
    let exploded = beside::exploded_in(&from).map_err(|error| StoreError::reading(&from, error))?;
    let others = [beside::METRICS, beside::EVENTS].map(|name| from.join(name));
    for path in exploded.into_iter().chain(others) {
        copy(&path, scratch)?;
    }
    let record = finite::to_string_pretty(&link).expect("a link has no numbers that are not finite");
    let place = scratch.join(FILE);
    safe_fs::replace(&place, record.as_bytes()).map_err(|error| StoreError::writing(&place, error))?;
    // Last: without it the training begins anew.
    copy(&Checkpoint::path(&from), scratch)?;
    Ok(Some(link))
}

/// The record of a training in the store, if it is the beginning of this one and has a final checkpoint.
fn link(store: &Store, stage: &Stage, key: Fingerprint) -> Option<Link> {
    let recipe = store.manifest(stage.kind, &key).ok()??.stage.recipe;
    let samples = stop(&recipe)?;
    let is_shorter = stop(&stage.recipe).is_none_or(|own| samples < own);
    let has_checkpoint = Checkpoint::path(&store.folder(stage.kind, &key)).is_file();
    let fits = is_shorter && has_checkpoint && whole_schedule(&recipe) == whole_schedule(&stage.recipe);
    fits.then_some(Link { fingerprint: key, samples })
}

fn stop(recipe: &Recipe) -> Option<u64> {
    recipe.fields.get("learn")?.get("stop_at")?.as_u64()
}

/// The recipe of the same training without an early stop.
fn whole_schedule(recipe: &Recipe) -> Recipe {
    let mut recipe = recipe.clone();
    if let Some(learn) = recipe.fields.get_mut("learn").and_then(Json::as_object_mut) {
        learn.shift_remove("stop_at");
    }
    recipe
}

fn copy(path: &Path, folder: &Path) -> Result<(), StoreError> {
    let place = folder.join(path.file_name().expect("a file has a name"));
    let bytes = bounded::bytes(path, bounded::ARTEFACT).map_err(|error| StoreError::reading(path, error.into()))?;
    safe_fs::replace(&place, &bytes).map_err(|error| StoreError::writing(&place, error))
}

/// Copies the record of the training that was continued, if there is one, from the scratch folder to the artefact.
pub fn keep_record(scratch: &Path, artefact: &Path) -> Result<(), StoreError> {
    let path = scratch.join(FILE);
    if !path.exists() {
        return Ok(());
    }
    let place = artefact.join(FILE);
    fs::copy(&path, &place).map(drop).map_err(|error| StoreError::writing(&place, error))
}
