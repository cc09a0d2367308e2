//! Garbage collection: removes what is provably unused. Artefacts without a name may be in use.

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::fault::StoreError;
use super::journal::Journal;
use super::lease;
use super::line_file::Health;
use super::lock::{self, Lock, Wait};
use super::manifest::{self, Depth, Manifest};
use super::marker::{self, Identity, is_real};
use super::store::Store;
use super::tensorboard;
use crate::bounded;
use crate::plan::{Cached, Fingerprint, StageKind};

/// Selects what may be removed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rules {
    /// Minimum age of artefacts to remove.
    pub age: Duration,
    /// Whether checkpoints of unfinished stages are removed too.
    pub scratch: bool,
    /// Whether to trust a damaged or missing journal, so that artefacts it does not name count as unused.
    pub force: bool,
}

/// An entry to remove.
#[derive(Debug)]
pub struct Waste {
    /// A description for people.
    pub what: String,
    /// Its path.
    pub path: PathBuf,
    /// Size in bytes.
    pub size: u64,
    /// Keeps other processes from using a checkpoint until it is removed.
    _lock: Option<Lock>,
}

/// What to remove, and what is kept although it seems unused.
#[derive(Debug, Default)]
pub struct Cleaning {
    /// What to remove.
    pub waste: Vec<Waste>,
    /// Old artefacts that the journal does not name, so that it is unknown whether they are used.
    pub unnamed: usize,
    /// Artefacts that the journal does not need but running processes use.
    pub leased: usize,
    /// The journal and where to move it, if it must be repaired.
    mend: Option<(Journal, PathBuf)>,
    /// Keeps runs from starting until everything is removed.
    _closed: Option<Lock>,
}

/// Finds what to remove: artefacts that the journal names, that are not the current one of any named stage,
/// are older than the age and unused by running processes; damaged artefacts of any age, which no stage can
/// use; and, if asked, checkpoints of stages that no process is running. E0813 if the folder is not a store,
/// E0814 if the journal is not reliable.
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
    artefacts(store, rules, &journal, &held, &mut cleaning)?;
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

/// Why the journal does not tell what is in use; `None` if it does.
fn evidence(store: &Store, journal: &Journal) -> Result<Option<String>, StoreError> {
    let mut is_empty = true;
    for kind in StageKind::ALL {
        is_empty &= store.entries(kind)?.is_empty();
    }
    Ok(match journal.health() {
        Health::Whole => None,
        _ if is_empty => None,
        Health::Absent => Some("it is missing".into()),
        Health::Damaged(reason) => Some(reason.clone()),
    })
}

fn artefacts(
    store: &Store,
    rules: &Rules,
    journal: &Journal,
    held: &BTreeSet<Fingerprint>,
    cleaning: &mut Cleaning,
) -> Result<(), StoreError> {
    let present: BTreeSet<&Fingerprint> = journal.present().collect();
    let known: BTreeSet<&Fingerprint> = journal.known().collect();
    for kind in StageKind::ALL {
        // A link leads out of the store.
        if !is_real(&store.root().join(kind.name()), Metadata::is_dir) {
            continue;
        }
        for key in store.entries(kind)? {
            let folder = store.folder(kind, &key);
            if matches!(store.inspect(kind, &key, Depth::Full), Cached::Damaged(_)) {
                let lock = lock::attempt(&store.lock_path(&key))?.filter(|_| !held.contains(&key));
                match lock {
                    Some(_) => {
                        let link = if folder.is_symlink() { "link in place of" } else { "damaged" };
                        let what = format!("{link} {} {}", kind.name(), key.short());
                        cleaning.waste.push(entry(what, folder));
                    }
                    None => cleaning.leased += 1,
                }
                continue;
            }
            if present.contains(&key) || is_recent(&folder, rules.age) {
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

/// Whether it is the report of a run with failures: it is shown once and never found in the store again.
fn is_partial_report(store: &Store, kind: StageKind, key: &Fingerprint) -> bool {
    let manifest = || store.manifest(kind, key).ok().flatten();
    kind == StageKind::Report
        && manifest().is_some_and(|found| found.stage.recipe.content.get("failures").is_some())
}

/// The checkpoint of a stage that no process is running or has planned, with its lock.
fn checkpoint(store: &Store, held: &BTreeSet<Fingerprint>, path: PathBuf) -> Option<Waste> {
    let key = Fingerprint::parse(&path.file_name()?.to_string_lossy()).filter(|key| !held.contains(key))?;
    let lock = lock::attempt(&store.lock_path(&key)).ok()??;
    Some(Waste { _lock: Some(lock), ..entry("checkpoint".into(), path) })
}

/// Removes the waste with the names that TensorBoard has for it, and repairs a journal that was overridden.
pub fn remove(store: &Store, cleaning: &Cleaning, wait: &Wait) -> Result<(), StoreError> {
    for Waste { path, .. } in &cleaning.waste {
        // Of a link only the link itself is removed.
        let is_folder = is_real(path, Metadata::is_dir);
        let removed = if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        removed.map_err(|error| StoreError::writing(path, error))?;
    }
    tensorboard::sweep(store);
    let Some((journal, folder)) = &cleaning.mend else { return Ok(()) };
    fs::create_dir_all(folder).map_err(|error| StoreError::writing(folder, error))?;
    let place = |number: usize| folder.join(format!("journal-{number}"));
    journal.mend(&(1..).map(place).find(|path| !path.exists()).unwrap_or_else(|| place(0)), wait)
}

/// Whether an artefact is younger than that age. Both the file's time and the manifest's must be known and
/// old: a missing time or one in the future proves no age.
fn is_recent(folder: &Path, age: Duration) -> bool {
    let path = folder.join(manifest::FILE);
    let made = path.metadata().and_then(|metadata| metadata.modified());
    let is_old = made.ok().and_then(|made| made.elapsed().ok()).is_some_and(|elapsed| elapsed >= age);
    let Some(limit) = SystemTime::now().checked_sub(age).and_then(manifest::stamp) else { return true };
    let text = bounded::text(&path, bounded::RECORD).ok();
    let finished =
        text.and_then(|text| Manifest::from_text(&text).ok()).map(|manifest| manifest.provenance.finished);
    // Such texts sort in the order of their times.
    let was_old = finished.is_some_and(|finished| finished.len() == limit.len() && finished <= limit);
    !(is_old && was_old)
}

fn entry(what: String, path: PathBuf) -> Waste {
    let size = size(&path);
    Waste { what, path, size, _lock: None }
}

/// The entries of a folder of the store, links among them; none if the folder itself is a link.
fn children(folder: &Path) -> Vec<PathBuf> {
    if !is_real(folder, Metadata::is_dir) {
        return Vec::new();
    }
    let entries = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let mut paths: Vec<PathBuf> = entries.collect();
    paths.sort();
    paths
}

/// Size in bytes of all files below a folder. Symlinks, which can lead out or form cycles, are not followed.
fn size(path: &Path) -> u64 {
    match path.symlink_metadata() {
        Ok(metadata) if metadata.is_dir() => children(path).iter().map(|child| size(child)).sum(),
        Ok(metadata) if metadata.is_file() => metadata.len(),
        _ => 0,
    }
}
