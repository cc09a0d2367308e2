//! Cleaning the store: what no named stage uses any more.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::fault::StoreError;
use super::journal::Journal;
use super::lock;
use super::manifest;
use super::store::Store;
use crate::plan::{Fingerprint, StageKind};

/// Something to be removed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waste {
    /// What it is, for people.
    pub what: String,
    /// Where it is.
    pub path: PathBuf,
    /// Bytes.
    pub size: u64,
}

/// What can go: artefacts that are not the present one of any named stage in the journal and were made
/// before `age`, damaged entries, and with `scratch` the checkpoints of stages that were not finished,
/// unless a process works on them.
pub fn waste(store: &Store, age: Duration, scratch: bool) -> Vec<Waste> {
    let used: BTreeSet<Fingerprint> = Journal::open(store).present().cloned().collect();
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
        let folders = children(&store.root().join("scratch"));
        let free = folders.into_iter().filter(|path| {
            let key = path.file_name().and_then(|name| Fingerprint::parse(&name.to_string_lossy()));
            key.is_some_and(|key| matches!(lock::attempt(&store.lock_path(&key)), Ok(Some(_))))
        });
        found.extend(free.map(|path| entry("checkpoint".into(), path)));
    }
    found
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
    Waste { what, path, size }
}

fn children(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// Bytes of all files below a folder.
fn size(path: &Path) -> u64 {
    if path.is_dir() {
        return children(path).iter().map(|child| size(child)).sum();
    }
    path.metadata().map_or(0, |metadata| metadata.len())
}
