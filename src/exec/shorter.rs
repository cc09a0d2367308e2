//! Trainings that differ only in `learn.stop_at`, so that one is the beginning of the other. The longer one
//! continues from the final checkpoint of the shorter one if that is in the store. The result is
//! bit-identical to an uninterrupted training, so the shorter one is not an input and is not part of the
//! longer one's fingerprint.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::fault::StoreError;
use super::manifest::{self, Depth};
use super::store::Store;
use super::strays;
use crate::kinds::learn::{Learner, Ppo};
use crate::learn::beside;
use crate::learn::checkpoint::Checkpoint;
use crate::plan::{Cached, Fingerprint, Recipe, Stage, StageKind};
use crate::spec::typed::InSection as _;
use crate::{bounded, finite, safe_fs};

/// Records which shorter training was continued; next to the checkpoint and in the longer one's artefact.
pub const FILE: &str = strays::CONTINUES;

/// A shorter training that another one continues.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Its fingerprint.
    pub fingerprint: Fingerprint,
    /// Number of samples it was trained on (`learn.stop_at`).
    pub samples: u64,
}

/// Where a training starts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Beginning {
    /// The training that it continues; `None` if it starts anew or from its own checkpoint.
    pub link: Option<Link>,
    /// Longer candidates that could not be continued.
    pub passed_over: Vec<PassedOver>,
    /// Trainings that cannot be compared with this one.
    pub unreadable: Vec<Unreadable>,
}

/// A training in the store whose manifest cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// Its fingerprint.
    pub fingerprint: Fingerprint,
    /// Why it cannot be read.
    pub reason: String,
}

/// A training that cannot be continued although it is the beginning of this one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassedOver {
    /// The training.
    pub link: Link,
    /// Why it cannot be continued.
    pub cause: Cause,
}

/// Why a training cannot be continued.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Its artefact was changed after it was made.
    Damaged(String),
    /// It was restored from a record without its checkpoint.
    Restored,
}

/// Copies the final checkpoint of the longest shorter training with the same schedule, and its files, to the
/// stage's scratch folder. Does nothing if the folder has a checkpoint or the stage is not a training.
pub fn lend(store: &Store, stage: &Stage, scratch: &Path) -> Result<Beginning, StoreError> {
    let mut beginning = Beginning::default();
    if stage.kind != StageKind::Learner || Checkpoint::path(scratch).exists() {
        return Ok(beginning);
    }
    let mut found = Vec::new();
    for key in store.keys(stage.kind).into_iter().filter(|key| *key != stage.fingerprint) {
        match link(store, stage, key) {
            Ok(link) => found.extend(link),
            Err(unreadable) => beginning.unreadable.push(unreadable),
        }
    }
    found.sort_by_key(|link| std::cmp::Reverse(link.samples));
    for link in found {
        match obstacle(store, stage.kind, &link) {
            Some(cause) => beginning.passed_over.push(PassedOver { link, cause }),
            None => {
                beginning.link = Some(link);
                break;
            }
        }
    }
    let Some(link) = &beginning.link else { return Ok(beginning) };
    let from = store.folder(stage.kind, &link.fingerprint);
    let exploded = beside::exploded_in(&from).map_err(|error| StoreError::reading(&from, error))?;
    let others = [beside::METRICS, beside::EVENTS].map(|name| from.join(name));
    for path in exploded.into_iter().chain(others) {
        copy(&path, scratch)?;
    }
    let record = finite::to_string_pretty(link).expect("a link has no numbers that are not finite");
    let place = scratch.join(FILE);
    safe_fs::replace(&place, record.as_bytes()).map_err(|error| StoreError::writing(&place, error))?;
    // Last, because without the checkpoint the training starts anew.
    copy(&Checkpoint::path(&from), scratch)?;
    Ok(beginning)
}

/// A training in the store, if it is the beginning of this one. Even a damaged manifest may be enough to
/// tell.
fn link(store: &Store, stage: &Stage, key: Fingerprint) -> Result<Option<Link>, Unreadable> {
    let recipe = match store.manifest(stage.kind, &key) {
        Ok(None) => return Ok(None),
        Ok(Some(manifest)) => manifest.stage.recipe,
        Err(error) => match remains(store, stage.kind, &key) {
            Some(recipe) => recipe,
            None => {
                let reason = match error {
                    StoreError::Damaged { reason, .. } => reason,
                    other => other.to_string(),
                };
                return Err(Unreadable { fingerprint: key, reason });
            }
        },
    };
    let Some(samples) = stop(&recipe) else { return Ok(None) };
    let is_shorter = stop(&stage.recipe).is_none_or(|own| samples < own);
    let is_same = is_shorter && whole_schedule(&recipe) == whole_schedule(&stage.recipe);
    Ok(is_same.then_some(Link { fingerprint: key, samples }))
}

/// The recipe in a damaged manifest, if it matches the fingerprint.
fn remains(store: &Store, kind: StageKind, key: &Fingerprint) -> Option<Recipe> {
    let text = bounded::text(&store.folder(kind, key).join(manifest::FILE), bounded::RECORD).ok()?;
    let mut json: Json = serde_json::from_str(&text).ok()?;
    let recipe: Recipe = serde_json::from_value(json.get_mut("stage")?.get_mut("recipe")?.take()).ok()?;
    (recipe.fingerprint() == *key).then_some(recipe)
}

/// Why a training in the store cannot be continued; `None` if it can.
fn obstacle(store: &Store, kind: StageKind, link: &Link) -> Option<Cause> {
    match store.inspect(kind, &link.fingerprint, Depth::Full) {
        Cached::Yes if Checkpoint::path(&store.folder(kind, &link.fingerprint)).is_file() => None,
        Cached::Yes => Some(Cause::Restored),
        Cached::Damaged(reason) => Some(Cause::Damaged(reason)),
        Cached::No => Some(Cause::Damaged("it is gone".into())),
    }
}

fn stop(recipe: &Recipe) -> Option<u64> {
    recipe.fields.get(Learner::SECTION)?.get(Ppo::stop_at.name)?.as_u64()
}

/// The recipe of the same training without an early stop.
fn whole_schedule(recipe: &Recipe) -> Recipe {
    let mut recipe = recipe.clone();
    if let Some(learn) = recipe.fields.get_mut(Learner::SECTION).and_then(Json::as_object_mut) {
        learn.shift_remove(Ppo::stop_at.name);
    }
    recipe
}

fn copy(path: &Path, folder: &Path) -> Result<(), StoreError> {
    let place = folder.join(path.file_name().expect("a file has a name"));
    let bytes =
        bounded::bytes(path, bounded::ARTEFACT).map_err(|error| StoreError::reading(path, error.into()))?;
    safe_fs::replace(&place, &bytes).map_err(|error| StoreError::writing(&place, error))
}

/// Copies the record of the training that was continued, if any, from the scratch folder to the artefact.
pub fn keep_record(scratch: &Path, artefact: &Path) -> Result<(), StoreError> {
    let path = scratch.join(FILE);
    if !path.exists() {
        return Ok(());
    }
    let place = artefact.join(FILE);
    fs::copy(&path, &place).map(drop).map_err(|error| StoreError::writing(&place, error))
}
