//! Records of runs: what a report needs of a finished run, as one small JSON file that can be committed.
//!
//! A record contains the manifests of the run's trainings and evaluations, their JSON files and the learning
//! curve of each training; the weights only on request. A run restored without weights is enough for a
//! report; a stage that needs the weights repeats the training, which gives bit-identical results.

mod curve;
mod names;
mod read;
mod restore;
mod save;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::fault::StoreError;
use crate::plan::fingerprint::canonical_json;
use curve::Curve;

pub use restore::{Restored, restore, verify};
pub use save::{Saved, save};

/// Incremented when existing keys change their meaning.
const FORMAT: u32 = 3;

/// A finished run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Format of the file.
    pub format: u32,
    /// The arm and its seed, as reports name the run.
    pub run: String,
    /// The name of its file without `.json`.
    pub file: String,
    /// The trainings and evaluations in the order of the pipeline.
    pub stages: Vec<StageRecord>,
    /// BLAKE3 of the record's canonical JSON without this field; empty until it is sealed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub seal: String,
}

/// A stage of a finished run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageRecord {
    /// The manifest with its digest, as stored.
    pub manifest: serde_json::Value,
    /// The stage's JSON files by name.
    pub files: BTreeMap<String, serde_json::Value>,
    /// The learning curve of a training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// Other files of the stage next to the record (the weights), by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub beside: BTreeMap<String, String>,
    /// BLAKE3 of the canonical JSON of `files` and `curve`, which the manifest's digests do not cover.
    pub digest: String,
}

/// Why a record cannot be written or restored.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The store cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A folder of records cannot be read.
    #[error("the records in {} cannot be read: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A folder has no records.
    #[error("no records of runs in {}: {reason}", path.display())]
    Absent {
        /// The folder.
        path: PathBuf,
        /// What its files are.
        reason: String,
    },
    /// A record cannot be written.
    #[error("the record {} cannot be written: {source}", path.display())]
    Unwritten {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that is not a record, or not its weights, has the name of one to be written.
    #[error("{} exists and is not a record of a run or its weights; nothing is written", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
    },
    /// A file is not a record, or was changed after it was written.
    #[error("{path}: {reason}")]
    Record {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

impl RecordError {
    fn at(path: impl Into<PathBuf>, reason: impl std::fmt::Display) -> Self {
        Self::Record { path: path.into(), reason: reason.to_string() }
    }
}

impl StageRecord {
    /// The digest of these files and this curve.
    fn digest_of(files: &BTreeMap<String, serde_json::Value>, curve: Option<&Curve>) -> String {
        let content = canonical_json(&serde_json::json!({ "files": files, "curve": curve }));
        blake3::hash(content.as_bytes()).to_hex().to_string()
    }
}
