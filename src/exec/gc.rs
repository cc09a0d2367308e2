//! Cleaning the store: what no named stage uses any more.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::fault::StoreError;
use super::journal::Journal;
use super::lock::{self, Lock};
use super::manifest;
use super::store::Store;
use crate::plan::{Fingerprint, StageKind};

/// Something to be removed.
#[derive(Debug)]
pub struct Waste {
    /// What it is, for people.
    pub what: String,
    /// Where it is.
    pub path: PathBuf,
    /// Bytes.
    pub size: u64,
    /// Keeps a checkpoint from being worked on until it is gone.
    _lock: Option<Lock>,
}

/// What can go: artefacts that are not the present one of any named stage in the journal and were made
/// before `age`, damaged entries, and with `scratch` the checkpoints of stages that were not finished,
/// unless a process works on them. A journal that cannot be read says of nothing that it is used, so then there is none.
pub fn waste(store: &Store, age: Duration, scratch: bool) -> Result<Vec<Waste>, StoreError> {
    let used: BTreeSet<Fingerprint> = Journal::open(store)?.present().cloned().collect();
    let mut found = Vec::new();
    for kind in StageKind::ALL {
        for key in store.keys(kind).into_iter().filter(|key| !used.contains(key)) {
            let folder = store.folder(kind, &key);
            if is_older(&folder, age) {
                found.push(entry(format!("{} {}", kind.name(), key.short()), folder));
            }
        }
    }
    found.extend(children(&store.root().join("damaged")).into_iter().map(|path| entry("damaged entry".into(), path)));
    if scratch {
        found.extend(children(&store.root().join("scratch")).into_iter().filter_map(|path| checkpoint(store, path)));
    }
    Ok(found)
}

/// The checkpoint of a stage that no process works on, with its lock.
fn checkpoint(store: &Store, path: PathBuf) -> Option<Waste> {
    let key = Fingerprint::parse(&path.file_name()?.to_string_lossy())?;
    let lock = lock::attempt(&store.lock_path(&key)).ok()??;
    Some(Waste { _lock: Some(lock), ..entry("checkpoint".into(), path) })
}

/// Removes waste.
pub fn remove(waste: &[Waste]) -> Result<(), StoreError> {
    for Waste { path, .. } in waste {
        fs::remove_dir_all(path).map_err(|error| StoreError::writing(path, error))?;
    }
    Ok(())
}

/// Whether an artefact was made before that age; what tells no time is old.
fn is_older(folder: &Path, age: Duration) -> bool {
    let made = folder.join(manifest::FILE).metadata().and_then(|metadata| metadata.modified());
    made.ok().and_then(|made| made.elapsed().ok()).is_none_or(|elapsed| elapsed >= age)
}

fn entry(what: String, path: PathBuf) -> Waste {
    let size = size(&path);
    Waste { what, path, size, _lock: None }
}

fn children(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// Bytes of all files below a folder. Symlinks are not followed: they can lead out of it, and in circles.
fn size(path: &Path) -> u64 {
    match path.symlink_metadata() {
        Ok(metadata) if metadata.is_dir() => children(path).iter().map(|child| size(child)).sum(),
        Ok(metadata) if metadata.is_file() => metadata.len(),
        _ => 0,
    }
}
