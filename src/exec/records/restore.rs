//! Puts the runs of records back into a store.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::read::read;
use super::{RecordError, StageRecord};
use crate::exec::fault::StoreError;
use crate::exec::lock::{self, Wait};
use crate::exec::manifest::{Depth, FileRecord, Manifest, Provenance};
use crate::exec::store::Store;
use crate::learn::beside::METRICS;
use crate::plan::{Cached, Stage};
use crate::{bounded, safe_fs};

/// What was restored.
#[derive(Debug, Default)]
pub struct Restored {
    /// Records that were read.
    pub records: usize,
    /// Stages that were put into the store.
    pub stages: usize,
    /// Stages that the store had already.
    pub present: usize,
    /// JSON files that are not records of runs, which were skipped.
    pub foreign: Vec<PathBuf>,
    /// Why records are not restored: they are damaged or of another version.
    pub refused: Vec<RecordError>,
}

/// Restores all whole records in a folder. Other files do not keep them from it. Stages that are in the store
/// already are left unchanged; waits for those that another process is making or restoring.
pub fn restore(store: &Store, folder: &Path, wait: &Wait) -> Result<Restored, RecordError> {
    let paths = records_in(folder)?;
    store.identity()?;
    let mut restored = Restored::default();
    for path in paths {
        if is_foreign(&path) {
            restored.foreign.push(path);
            continue;
        }
        // Check the whole record before restoring any of it.
        let stages = read(&path).and_then(|record| {
            record.stages.iter().map(|stage| whole(stage, folder)).collect::<Result<Vec<_>, _>>()
        });
        let stages = match stages {
            Ok(stages) => stages,
            Err(reason) => {
                restored.refused.push(RecordError::at(&path, reason));
                continue;
            }
        };
        if restored.records == 0 {
            store.prepare()?;
        }
        restored.records += 1;
        for stage in &stages {
            let is_new = restore_stage(store, stage, wait)?;
            *(if is_new { &mut restored.stages } else { &mut restored.present }) += 1;
        }
    }
    match restored.records + restored.refused.len() {
        0 => Err(RecordError::Absent { path: folder.to_owned(), reason: "none of its files is one".into() }),
        _ => Ok(restored),
    }
}

/// A stage whose record is consistent.
struct WholeStage {
    stage: Stage,
    provenance: Provenance,
    /// The files of the original artefact.
    originals: Vec<FileRecord>,
    /// The files that are restored, by name.
    files: BTreeMap<String, Vec<u8>>,
}

/// Checks a stage's record: its digests, and that it has exactly the JSON files of the artefact.
fn whole(record: &StageRecord, folder: &Path) -> Result<WholeStage, String> {
    let Manifest { stage, files: listed, provenance, originals } =
        Manifest::from_text(&record.manifest.to_string())?;
    let kind = stage.kind.name();
    let wrong = |reason: String| format!("the record of `{kind}` {}: {reason}", stage.fingerprint.short());
    if stage.recipe.fingerprint() != stage.fingerprint {
        return Err(wrong("its recipe is not that of its fingerprint".into()));
    }
    if StageRecord::digest_of(&record.files, record.curve.as_ref()) != record.digest {
        return Err(wrong("its files or its curve are not as they were written".into()));
    }
    let originals = if originals.is_empty() { listed } else { originals };
    let mut files = BTreeMap::new();
    for (name, value) in &record.files {
        files.insert(
            name.clone(),
            serde_json::to_vec_pretty(value).map_err(|error| wrong(error.to_string()))?,
        );
    }
    if let Some(curve) = &record.curve {
        files.insert(METRICS.to_owned(), curve.lines().map_err(wrong)?.into_bytes());
    }
    for (name, beside) in &record.beside {
        let path = safe_fs::inside(folder, beside).map_err(|error| wrong(error.to_string()))?;
        let bytes =
            bounded::bytes(&path, bounded::ARTEFACT).map_err(|error| wrong(format!("{beside}: {error}")))?;
        let digest = blake3::hash(&bytes).to_hex();
        if originals.iter().all(|file| file.path != *name || file.blake3 != digest.as_str()) {
            return Err(wrong(format!("{beside} does not have the digest of `{name}`")));
        }
        files.insert(name.clone(), bytes);
    }
    let is_kept = |file: &&FileRecord| file.path.ends_with(".json") || file.path == METRICS;
    if let Some(file) = originals.iter().filter(is_kept).find(|file| !files.contains_key(&file.path)) {
        return Err(wrong(format!("`{}` is missing", file.path)));
    }
    match files.keys().find(|name| originals.iter().all(|file| file.path != **name)) {
        Some(name) => Err(wrong(format!("`{name}` is not a file of the stage"))),
        None => Ok(WholeStage { stage, provenance, originals, files }),
    }
}

/// Checks that a file is an unchanged record of a run with its weights next to it. `None` if it is not a
/// record of a run.
pub fn verify(path: &Path) -> Option<Result<(), String>> {
    let text = bounded::text(path, bounded::RECORD).ok()?;
    let json: serde_json::Value = serde_json::from_str(&text).ok()?;
    if !is_like_a_record(&json) {
        return None;
    }
    let folder = safe_fs::folder_of(path);
    Some(
        read(path)
            .and_then(|record| record.stages.iter().try_for_each(|stage| whole(stage, folder).map(drop))),
    )
}

/// Whether JSON has the form of a record of a run, of any version, whole or edited.
fn is_like_a_record(json: &serde_json::Value) -> bool {
    json.get("stages").is_some() && (json.get("format").is_some() || json.get("run").is_some())
}

/// Whether a file is JSON of another kind, or a folder. One that is not JSON may be a truncated record.
fn is_foreign(path: &Path) -> bool {
    let json = || serde_json::from_str(&bounded::text(path, bounded::RECORD).ok()?).ok();
    path.is_dir() || json().is_some_and(|json| !is_like_a_record(&json))
}

/// The JSON files in a folder, sorted by name.
fn records_in(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let fault = |source: std::io::Error| RecordError::Folder { path: folder.to_owned(), source };
    let entries = folder.read_dir().map_err(fault)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = entries.collect::<Result<Vec<_>, _>>().map_err(fault)?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    if paths.is_empty() {
        let reason = "none of its files ends with `.json`".to_owned();
        return Err(RecordError::Absent { path: folder.to_owned(), reason });
    }
    Ok(paths)
}

/// Restores a stage under its lock, so that only one of several processes does. Returns whether it did.
fn restore_stage(store: &Store, whole: &WholeStage, wait: &Wait) -> Result<bool, StoreError> {
    let (kind, key) = (whole.stage.kind, &whole.stage.fingerprint);
    if store.inspect(kind, key, Depth::Quick) == Cached::Yes {
        return Ok(false);
    }
    let _lock = lock::exclusive(&store.lock_path(key), wait)?;
    match store.inspect(kind, key, Depth::Quick) {
        Cached::Yes => return Ok(false),
        Cached::No => {}
        Cached::Damaged(_) => drop(store.quarantine(kind, key)?),
    }
    let draft = store.begin(&whole.stage)?;
    for (name, bytes) in &whole.files {
        let path = safe_fs::inside(draft.folder(), name)
            .map_err(|error| StoreError::writing(draft.folder(), error))?;
        fs::write(&path, bytes).map_err(|error| StoreError::writing(&path, error))?;
    }
    draft.commit_reduced(whole.provenance.clone(), whole.originals.clone()).map(|_| true)
}
