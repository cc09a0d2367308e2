//! The content-addressed store: one folder per artefact, `KIND/FINGERPRINT/`, created by one rename.
//!
//! Besides the artefacts it has `tmp/` (artefacts being made), `scratch/` (checkpoints), `locks/`, `leases/`
//! (what running processes use), `damaged/` (entries whose digests do not match), `tensorboard/` (links to the
//! trainings by name), `journal.jsonl` with its seal, and the marker file. Does not interpret the content of artefacts.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::fault::StoreError;
use super::lease::{self, Lease};
use super::line_file::LineFile;
use super::lock::{self, Lock, Wait};
use super::manifest::{self, Depth, FileRecord, Manifest, Provenance};
use super::marker::{self, Identity};
use super::{strays, verify};
use crate::learn::checkpoint::Checkpoint;
use crate::plan::{Cached, Fingerprint, Plan, Stage, StageKind};
use crate::{bounded, finite, safe_fs};

/// The store. Reading it creates nothing; [`Store::prepare`] does.
#[derive(Clone, Debug)]
pub struct Store {
    root: PathBuf,
    /// A store that is only read: its artefacts count as this store's.
    base: Option<PathBuf>,
}

impl Store {
    /// The store in this folder, which need not exist yet.
    pub fn at(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), base: None }
    }

    /// A store in this folder that also has the artefacts of another one, to which it writes nothing.
    pub fn over(base: &Self, root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), base: Some(base.root.clone()) }
    }

    /// Whether the store can be written, or created. If not, its artefacts may still be readable.
    pub fn is_writable(&self) -> bool {
        self.prepare().is_ok()
    }

    /// Its folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What its folder is; E0813 if the folder is not a store and cannot become one.
    pub fn identity(&self) -> Result<Identity, StoreError> {
        self.refuse_links()?;
        match marker::identity(&self.root)? {
            Identity::Other { reason, vacant: false } => {
                Err(StoreError::NotAStore { path: self.root.clone(), reason })
            }
            identity => Ok(identity),
        }
    }

    /// Creates the store's folders, checks that they are writable, and removes what killed runs left in
    /// `tmp/`. Refuses a folder that contains anything else: a store needs a folder of its own.
    pub fn prepare(&self) -> Result<(), StoreError> {
        let identity = self.identity()?;
        for folder in ["", "tmp", "scratch", "locks"] {
            let path = self.root.join(folder);
            fs::create_dir_all(&path).map_err(|error| StoreError::writing(&path, error))?;
        }
        if matches!(identity, Identity::Absent | Identity::Other { .. }) {
            LineFile::new(&self.root).begin()?;
        }
        if identity != Identity::Marked {
            marker::mark(&self.root)?;
        }
        // A store is a cache; keep it out of version control.
        let ignore = self.root.join(".gitignore");
        if !ignore.exists() {
            safe_fs::replace(&ignore, b"*\n").map_err(|error| StoreError::writing(&ignore, error))?;
        }
        let probe = self.root.join("tmp").join(format!("probe.{}", std::process::id()));
        fs::write(&probe, "probe").map_err(|error| StoreError::writing(&probe, error))?;
        let _ = fs::remove_file(&probe);
        self.sweep();
        Ok(())
    }

    /// Refuses symbolic links inside the store, which would make a run write elsewhere. The store's own
    /// folder may be one.
    fn refuse_links(&self) -> Result<(), StoreError> {
        let own = marker::FOLDERS.into_iter().chain(marker::FILES);
        for name in own.chain(StageKind::ALL.map(StageKind::name)) {
            let path = self.root.join(name);
            safe_fs::refuse_link(&path).map_err(|error| StoreError::writing(&path, error))?;
        }
        Ok(())
    }

    /// Removes temporary folders whose processes have ended, that is, whose lock is free.
    fn sweep(&self) {
        let Ok(entries) = self.root.join("tmp").read_dir() else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(key) = name.split('.').next().and_then(Fingerprint::parse) else { continue };
            if let Ok(Some(_lock)) = lock::attempt(&self.lock_path(&key)) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }

    /// The folder of an artefact.
    pub fn folder(&self, kind: StageKind, key: &Fingerprint) -> PathBuf {
        self.holder(kind, key).join(kind.name()).join(key.as_str())
    }

    /// The folder of the store that has an artefact; its own for one that is missing.
    fn holder(&self, kind: StageKind, key: &Fingerprint) -> &Path {
        let has = |root: &Path| root.join(kind.name()).join(key.as_str()).exists();
        match &self.base {
            Some(base) if has(base) && !has(&self.root) => base,
            _ => &self.root,
        }
    }

    /// Whether an artefact is that of the store below this one, in which nothing is changed.
    pub fn is_borrowed(&self, kind: StageKind, key: &Fingerprint) -> bool {
        self.holder(kind, key) != self.root
    }

    /// The file that is locked while an artefact is made.
    pub fn lock_path(&self, key: &Fingerprint) -> PathBuf {
        self.root.join("locks").join(key.as_str())
    }

    /// The keys of all artefacts of a kind, sorted; empty if the folder cannot be read.
    pub fn keys(&self, kind: StageKind) -> Vec<Fingerprint> {
        self.entries(kind).unwrap_or_default()
    }

    /// The keys of all artefacts of a kind, sorted.
    pub fn entries(&self, kind: StageKind) -> Result<Vec<Fingerprint>, StoreError> {
        let mut keys = Self::entries_of(&self.root, kind)?;
        if let Some(base) = &self.base {
            keys.extend(Self::entries_of(base, kind)?);
        }
        keys.sort();
        keys.dedup();
        Ok(keys)
    }

    fn entries_of(root: &Path, kind: StageKind) -> Result<Vec<Fingerprint>, StoreError> {
        let folder = root.join(kind.name());
        let fault = |error| StoreError::reading(&folder, error);
        let entries = match folder.read_dir() {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(fault)?,
        };
        let mut keys = Vec::new();
        for entry in entries {
            keys.extend(Fingerprint::parse(&entry.map_err(fault)?.file_name().to_string_lossy()));
        }
        Ok(keys)
    }

    /// The manifest of an artefact; `None` if the artefact is missing.
    pub fn manifest(&self, kind: StageKind, key: &Fingerprint) -> Result<Option<Manifest>, StoreError> {
        let path = self.folder(kind, key).join(manifest::FILE);
        let file = format!("{}/{key}/{}", kind.name(), manifest::FILE);
        if let Err(error) = safe_fs::inside(self.holder(kind, key), &file) {
            return Err(StoreError::Damaged { path, reason: error.to_string() });
        }
        match bounded::text(&path, bounded::RECORD) {
            Ok(text) => {
                Manifest::from_text(&text).map(Some).map_err(|reason| StoreError::Damaged { path, reason })
            }
            Err(error) if error.is_absence() && !self.folder(kind, key).exists() => Ok(None),
            Err(error) => Err(StoreError::Damaged { path, reason: error.to_string() }),
        }
    }

    /// Whether an artefact is there and whole.
    pub fn inspect(&self, kind: StageKind, key: &Fingerprint, depth: Depth) -> Cached {
        match self.manifest(kind, key) {
            Ok(None) => Cached::No,
            Ok(Some(manifest)) => match verify::check(&manifest, &self.folder(kind, key), kind, key, depth) {
                Ok(()) => Cached::Yes,
                Err(reason) => Cached::Damaged(reason),
            },
            Err(StoreError::Damaged { reason, .. }) => Cached::Damaged(reason),
            Err(error) => Cached::Damaged(error.to_string()),
        }
    }

    /// The files in an artefact's folder that are not part of it, as paths in the folder.
    pub fn strays(&self, kind: StageKind, key: &Fingerprint) -> Vec<String> {
        let manifest = self.manifest(kind, key).ok().flatten();
        manifest.map_or_else(Vec::new, |manifest| strays::of(&manifest, &self.folder(kind, key)))
    }

    /// Moves a damaged entry to `damaged/`, and returns its new path.
    pub fn quarantine(&self, kind: StageKind, key: &Fingerprint) -> Result<PathBuf, StoreError> {
        let folder = self.root.join("damaged");
        fs::create_dir_all(&folder).map_err(|error| StoreError::writing(&folder, error))?;
        let place = |number: usize| folder.join(format!("{}-{}-{number}", kind.name(), key.short()));
        let target = (1..).map(place).find(|path| !path.exists()).expect("there are numbers enough");
        match fs::rename(self.folder(kind, key), &target) {
            // Another run may have moved it already.
            Err(error) if error.kind() != ErrorKind::NotFound => Err(StoreError::writing(&target, error)),
            _ => Ok(target),
        }
    }

    /// Takes the lock of a fingerprint; waits if another run holds it.
    pub fn lock(&self, key: &Fingerprint, wait: &Wait) -> Result<Lock, StoreError> {
        lock::lasting(&self.lock_path(key), wait)
    }

    /// Protects the artefacts of a plan from `cache gc` until the lease is dropped.
    pub fn lease(&self, plan: &Plan, wait: &Wait) -> Result<Lease, StoreError> {
        self.refuse_links()?;
        lease::take(&self.root, plan, wait)
    }

    /// The folder for a stage's checkpoints, which survives interruptions and crashes.
    pub fn scratch(&self, key: &Fingerprint) -> Result<PathBuf, StoreError> {
        let path = self.root.join("scratch").join(key.as_str());
        safe_fs::refuse_link(&path).map_err(|error| StoreError::writing(&path, error))?;
        fs::create_dir_all(&path).map_err(|error| StoreError::writing(&path, error))?;
        Ok(path)
    }

    /// The stages whose checkpoints are damaged, with the reasons.
    pub fn damaged_checkpoints(&self) -> Vec<(Fingerprint, String)> {
        let folders = self.root.join("scratch").read_dir().into_iter().flatten().flatten();
        let mut keys: Vec<Fingerprint> =
            folders.filter_map(|folder| Fingerprint::parse(&folder.file_name().to_string_lossy())).collect();
        keys.sort();
        let fault = |key: Fingerprint| {
            let reason = Checkpoint::fault(&self.root.join("scratch").join(key.as_str()))?;
            Some((key, reason))
        };
        keys.into_iter().filter_map(fault).collect()
    }

    /// Starts an artefact. The caller must hold the fingerprint's lock.
    pub fn begin(&self, stage: &Stage) -> Result<Draft<'_>, StoreError> {
        let name = format!("{}.{}", stage.fingerprint, std::process::id());
        let folder = self.root.join("tmp").join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).map_err(|error| StoreError::writing(&folder, error))?;
        Ok(Draft { store: self, stage: stage.clone(), folder })
    }
}

/// An artefact being made; removed when dropped without [`Draft::commit`].
#[derive(Debug)]
pub struct Draft<'a> {
    store: &'a Store,
    stage: Stage,
    folder: PathBuf,
}

impl Draft<'_> {
    /// Where to write its files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Puts the artefact into the store: digests, manifest, fsync, one rename. Removes the scratch folder.
    pub fn commit(self, provenance: Provenance) -> Result<PathBuf, StoreError> {
        self.commit_reduced(provenance, Vec::new())
    }

    /// The same for some of the files of an artefact; `originals` lists those that it had when it was made.
    pub fn commit_reduced(
        self,
        provenance: Provenance,
        originals: Vec<FileRecord>,
    ) -> Result<PathBuf, StoreError> {
        let fault = |error| StoreError::writing(&self.folder, error);
        let manifest = Manifest::describe(&self.folder, &self.stage, provenance).map_err(fault)?;
        let manifest = Manifest { originals, ..manifest };
        finite::check(&manifest)
            .map_err(|found| StoreError::NotFinite { file: manifest::FILE.into(), found })?;
        let mut file = File::create(self.folder.join(manifest::FILE)).map_err(fault)?;
        file.write_all(manifest.to_text().as_bytes()).and_then(|()| file.sync_all()).map_err(fault)?;
        for record in &manifest.files {
            File::open(self.folder.join(&record.path)).and_then(|file| file.sync_all()).map_err(fault)?;
        }
        sync_folder(&self.folder).map_err(fault)?;
        let parent = self.store.root.join(self.stage.kind.name());
        let target = parent.join(self.stage.fingerprint.as_str());
        fs::create_dir_all(&parent).map_err(|error| StoreError::writing(&parent, error))?;
        match fs::rename(&self.folder, &target) {
            Ok(()) => {}
            // Another process stored the same artefact; both are valid.
            Err(error) if matches!(error.kind(), ErrorKind::DirectoryNotEmpty | ErrorKind::AlreadyExists) => {
            }
            Err(error) => return Err(StoreError::writing(&target, error)),
        }
        sync_folder(&parent).map_err(|error| StoreError::writing(&parent, error))?;
        let _ = fs::remove_dir_all(self.store.root.join("scratch").join(self.stage.fingerprint.as_str()));
        Ok(target)
    }
}

impl Drop for Draft<'_> {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

fn sync_folder(path: &Path) -> std::io::Result<()> {
    File::open(path)?.sync_all()
}
