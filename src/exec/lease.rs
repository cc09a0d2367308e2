//! Leases mark what running processes use. A run leases every artefact of its plan until its report is
//! published, so that a concurrent `cache gc` does not remove them.
//!
//! A lease is a file of keys in `leases/`, locked while it is valid. It ends with the process, however that
//! ends.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::fault::StoreError;
use super::lock::{self, Lock, Wait};
use crate::bounded;
use crate::plan::{Fingerprint, Plan};

/// The lock of the whole store: shared while a lease is being taken, exclusive while artefacts are removed.
const STORE: &str = "locks/store";

/// A lease, valid until dropped.
#[derive(Debug)]
pub struct Lease {
    path: PathBuf,
    _lock: Lock,
}

impl Drop for Lease {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Leases all artefacts of a plan; waits while artefacts are being removed.
pub fn take(root: &Path, plan: &Plan, wait: &Wait) -> Result<Lease, StoreError> {
    static NUMBER: AtomicUsize = AtomicUsize::new(0);
    for folder in ["locks", "leases"].map(|name| root.join(name)) {
        fs::create_dir_all(&folder).map_err(|error| StoreError::writing(&folder, error))?;
    }
    let _store = lock::shared(&root.join(STORE), wait)?;
    let name = format!("{}.{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed));
    let path = root.join("leases").join(name);
    let lock = lock::exclusive(&path, wait)?;
    let keys: String = plan.stages().map(|stage| format!("{}\n", stage.fingerprint)).collect();
    let lease = Lease { path, _lock: lock };
    fs::write(&lease.path, keys).map_err(|error| StoreError::writing(&lease.path, error))?;
    Ok(lease)
}

/// Prevents new leases until dropped.
pub fn close(root: &Path, wait: &Wait) -> Result<Lock, StoreError> {
    let path = root.join(STORE);
    let folder = root.join("locks");
    fs::create_dir_all(&folder).map_err(|error| StoreError::writing(&folder, error))?;
    lock::exclusive(&path, wait)
}

/// The keys of all valid leases. Removes the leases of processes that ended; the caller must have called
/// [`close`].
pub fn held(root: &Path) -> Result<BTreeSet<Fingerprint>, StoreError> {
    let folder = root.join("leases");
    let entries = match folder.read_dir() {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeSet::new()),
        Err(error) => return Err(StoreError::reading(&folder, error)),
    };
    let mut keys = BTreeSet::new();
    for entry in entries {
        let path = entry.map_err(|error| StoreError::reading(&folder, error))?.path();
        if lock::attempt(&path)?.is_some() {
            let _ = fs::remove_file(&path);
            continue;
        }
        let text = bounded::text(&path, bounded::RECORD)
            .map_err(|error| StoreError::reading(&path, error.into()))?;
        for line in text.lines() {
            let unknown =
                || StoreError::Damaged { path: path.clone(), reason: format!("`{line}` is not a key") };
            keys.insert(Fingerprint::parse(line).ok_or_else(unknown)?);
        }
    }
    Ok(keys)
}
