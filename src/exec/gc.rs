//! Cleaning the store: what provably no named stage uses any more. A missing name proves nothing.

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::fault::StoreError;
use super::journal::Journal;
use super::lease;
use super::line_file::Health;
use super::lock::{self, Lock, Wait};
use super::manifest::{self, Manifest};
use super::marker::{self, Identity, is_real};
use super::store::Store;
use crate::bounded;
use crate::plan::{Fingerprint, StageKind};

/// What may be removed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rules {
    /// The youngest age of artefacts that go.
    pub age: Duration,
    /// Whether the checkpoints of stages that were not finished go too.
    pub scratch: bool,
    /// Whether a journal that is damaged or missing is taken as it is, and artefacts that it does not name
    /// are unused.
    pub force: bool,
}

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

/// What can go, and what is kept although nothing seems to use it.
#[derive(Debug, Default)]
pub struct Cleaning {
    /// What can go.
    pub waste: Vec<Waste>,
    /// Old artefacts that no line of the journal names: nobody knows whether they are used.
    pub unnamed: usize,
    /// Artefacts that running processes use and the journal does not need.
    pub leased: usize,
    /// The journal, where it has to be mended.
    mend: Option<(Journal, PathBuf)>,
    /// Keeps runs from starting until everything is gone.
    _closed: Option<Lock>,
}

/// What can go: artefacts that the journal names, that are not the present one of any named stage, were made
/// before the age, and are used by no running process; damaged entries; and, if asked, the checkpoints of
/// stages that no process works on. E0813 for a folder that is not a store, E0814 when the journal is no
/// evidence.
pub fn waste(store: &Store, rules: &Rules, wait: &Wait) -> Result<Cleaning, StoreError> {
    let root = store.root();
    match marker::identity(root)? {
        Identity::Absent => return Ok(Cleaning::default()),
        Identity::Marked | Identity::Unmarked => {}
        Identity::Other { reason, .. } => {
            return Err(StoreError::NotAStore { path: root.to_owned(), reason });
        }
    }
    let closed = lease::close(root, wait)?;
    let held = lease::held(root)?;
    let journal = Journal::open(store)?;
    let evidence = evidence(store, &journal)?;
    if let (Some(reason), false) = (&evidence, rules.force) {
        return Err(StoreError::Journal { path: root.to_owned(), reason: reason.clone() });
    }
    let mut cleaning = Cleaning { _closed: Some(closed), ..Cleaning::default() };
    artefacts((store, rules), (&journal, &held), &mut cleaning)?;
    let damaged = children(&root.join("damaged")).into_iter().filter(|path| marker::is_damaged(path));
    cleaning.waste.extend(damaged.map(|path| entry("damaged entry".into(), path)));
    if rules.scratch {
        let idle = |path: PathBuf| checkpoint(store, &held, path);
        cleaning.waste.extend(children(&root.join("scratch")).into_iter().filter_map(idle));
    }
    if evidence.is_some() {
        cleaning.mend = Some((journal, root.join("damaged")));
    }
    Ok(cleaning)
}

/// Why the journal does not say what is used; `None` when it does.
fn evidence(store: &Store, journal: &Journal) -> Result<Option<String>, StoreError> {
    let mut is_empty = true;
    for kind in StageKind::ALL {
        is_empty &= store.entries(kind)?.is_empty();
    }
    Ok(match journal.health() {
        Health::Whole => None,
        _ if is_empty => None,
        Health::Absent => Some("it is missing".into()),
        Health::Unchecked => Some("it is of a version that wrote no digests".into()),
        Health::Damaged(reason) => Some(reason.clone()),
    })
}

fn artefacts(
    (store, rules): (&Store, &Rules),
    (journal, held): (&Journal, &BTreeSet<Fingerprint>),
    cleaning: &mut Cleaning,
) -> Result<(), StoreError> {
    let present: BTreeSet<&Fingerprint> = journal.present().collect();
    let known: BTreeSet<&Fingerprint> = journal.known().collect();
    for kind in StageKind::ALL {
        // A link leads out of the store.
        if !is_real(&store.root().join(kind.name()), Metadata::is_dir) {
            continue;
        }
        for key in store.entries(kind)?.into_iter().filter(|key| !present.contains(key)) {
            let folder = store.folder(kind, &key);
            if !is_real(&folder, Metadata::is_dir) || is_recent(&folder, rules.age) {
                continue;
            }
            let is_passing = held.is_empty() && is_partial_report(store, kind, &key);
            if held.contains(&key) {
                cleaning.leased += 1;
            } else if !known.contains(&key) && !rules.force && !is_passing {
                cleaning.unnamed += 1;
            } else if lock::attempt(&store.lock_path(&key))?.is_some() {
                cleaning.waste.push(entry(format!("{} {}", kind.name(), key.short()), folder));
            }
        }
    }
    Ok(())
}

/// Whether it is the report of a run that had failures: such a one is shown once, and never found again.
fn is_partial_report(store: &Store, kind: StageKind, key: &Fingerprint) -> bool {
    let manifest = || store.manifest(kind, key).ok().flatten();
    kind == StageKind::Report
        && manifest().is_some_and(|found| found.stage.recipe.content.get("failures").is_some())
}

/// The checkpoint of a stage that no process works on or will, with its lock.
fn checkpoint(store: &Store, held: &BTreeSet<Fingerprint>, path: PathBuf) -> Option<Waste> {
    let key = Fingerprint::parse(&path.file_name()?.to_string_lossy()).filter(|key| !held.contains(key))?;
    let lock = lock::attempt(&store.lock_path(&key)).ok()??;
    Some(Waste { _lock: Some(lock), ..entry("checkpoint".into(), path) })
}

/// Removes the waste, and mends a journal that was overruled.
pub fn remove(cleaning: &Cleaning, wait: &Wait) -> Result<(), StoreError> {
    for Waste { path, .. } in &cleaning.waste {
        let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        removed.map_err(|error| StoreError::writing(path, error))?;
    }
    let Some((journal, folder)) = &cleaning.mend else { return Ok(()) };
    fs::create_dir_all(folder).map_err(|error| StoreError::writing(folder, error))?;
    let place = |number: usize| folder.join(format!("journal-{number}"));
    journal.mend(&(1..).map(place).find(|path| !path.exists()).unwrap_or_else(|| place(0)), wait)
}

/// Whether an artefact was made after that age. The file's time and the manifest's must both be known and
/// old: a time in the future, or none, proves no age.
fn is_recent(folder: &Path, age: Duration) -> bool {
    let path = folder.join(manifest::FILE);
    let made = path.metadata().and_then(|metadata| metadata.modified());
    let is_old = made.ok().and_then(|made| made.elapsed().ok()).is_some_and(|elapsed| elapsed >= age);
    let Some(limit) = SystemTime::now().checked_sub(age).and_then(manifest::stamp) else { return true };
    let text = bounded::text(&path, bounded::RECORD).ok();
    let finished =
        text.and_then(|text| Manifest::from_text(&text).ok()).map(|manifest| manifest.provenance.finished);
    // Such texts sort as their times do.
    let was_old = finished.is_some_and(|finished| finished.len() == limit.len() && finished <= limit);
    !(is_old && was_old)
}

fn entry(what: String, path: PathBuf) -> Waste {
    let size = size(&path);
    Waste { what, path, size, _lock: None }
}

/// What lies in a folder of the store; nothing of what is a link.
fn children(folder: &Path) -> Vec<PathBuf> {
    if !is_real(folder, Metadata::is_dir) {
        return Vec::new();
    }
    let entries = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let mut paths: Vec<PathBuf> = entries.filter(|path| !path.is_symlink()).collect();
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
