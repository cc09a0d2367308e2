//! Puts the runs of records back into a store.

use std::fs;
use std::path::{Path, PathBuf};

use super::{FORMAT, RecordError, RunRecord, StageRecord, manifest};
use crate::exec::manifest::{Depth, Manifest};
use crate::exec::store::Store;
use crate::plan::Cached;
use crate::{bounded, safe_fs};

/// What was restored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Restored {
    /// Records that were read.
    pub records: usize,
    /// Stages that were put into the store.
    pub stages: usize,
    /// Stages that the store had already.
    pub present: usize,
}

/// Restores all records in a folder. A stage that the store has stays as it is.
pub fn restore(store: &Store, folder: &Path) -> Result<Restored, RecordError> {
    store.prepare()?;
    let mut restored = Restored::default();
    for path in records_in(folder)? {
        let text = bounded::text(&path, bounded::RECORD).map_err(|error| RecordError::at(&path, error))?;
        let record: RunRecord = serde_json::from_str(&text)
            .map_err(|error| RecordError::at(&path, format!("it is not the record of a run: {error}")))?;
        if record.format != FORMAT {
            let reason = format!("its format is {}, this version reads {FORMAT}", record.format);
            return Err(RecordError::at(&path, reason));
        }
        restored.records += 1;
        for stage in &record.stages {
            let is_new = restore_stage(store, stage, folder).map_err(|reason| RecordError::at(&path, reason))?;
            *(if is_new { &mut restored.stages } else { &mut restored.present }) += 1;
        }
    }
    Ok(restored)
}

/// The records in a folder, sorted by name.
fn records_in(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let fault = |error: std::io::Error| RecordError::at(folder, error);
    let entries = folder.read_dir().map_err(fault)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = entries.collect::<Result<Vec<_>, _>>().map_err(fault)?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    Ok(paths)
}

/// Whether the stage was put into the store.
fn restore_stage(store: &Store, record: &StageRecord, folder: &Path) -> Result<bool, String> {
    let Manifest { stage, files, provenance, originals } = manifest(record)?;
    let originals = if originals.is_empty() { files } else { originals };
    let (kind, key) = (stage.kind, stage.fingerprint.clone());
    if stage.recipe.fingerprint() != key {
        return Err(format!("the recipe of `{}` is not that of its fingerprint", kind.name()));
    }
    if store.inspect(kind, &key, Depth::Quick) == Cached::Yes {
        return Ok(false);
    }
    let draft = store.begin(&stage).map_err(|error| error.to_string())?;
    let write = |name: &str, bytes: &[u8]| {
        let path = safe_fs::inside(draft.folder(), name).map_err(|error| error.to_string())?;
        fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()))
    };
    for (name, value) in &record.files {
        let text = serde_json::to_string_pretty(value).map_err(|error| error.to_string())?;
        write(name, text.as_bytes())?;
    }
    if let Some(curve) = &record.curve {
        write("metrics.jsonl", curve.lines()?.as_bytes())?;
    }
    for (name, beside) in &record.beside {
        let path = safe_fs::inside(folder, beside).map_err(|error| error.to_string())?;
        let bytes = bounded::bytes(&path, bounded::ARTEFACT).map_err(|error| format!("{beside}: {error}"))?;
        let original = originals.iter().find(|file| file.path == *name);
        let digest = blake3::hash(&bytes).to_hex();
        if original.is_none_or(|original| original.blake3 != digest.as_str()) {
            return Err(format!("{beside} does not have the digest of `{name}`"));
        }
        write(name, &bytes)?;
    }
    draft.commit_reduced(provenance, originals).map_err(|error| error.to_string())?;
    Ok(true)
}
