//! The journal: which artefact a named stage had, run after run. It lets `why` compare a stage with
//! its own previous version rather than with a stranger of the same kind.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::fault::StoreError;
use super::manifest::Depth;
use super::store::Store;
use crate::plan::why::{self, Previous};
use crate::plan::{Cached, Fingerprint, History, Stage, StageKind, User};

/// How many artefacts of a kind are looked through for the nearest one.
const NEAREST_LIMIT: usize = 64;

/// One line of the journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The run.
    pub run: String,
    /// The arm.
    pub arm: String,
    /// The stage's name in that arm.
    pub stage: String,
    /// Its kind.
    pub kind: StageKind,
    /// The artefact.
    pub fingerprint: Fingerprint,
}

/// The journal of a store.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    lines: Vec<Line>,
    latest: BTreeMap<User, Fingerprint>,
    /// The lines of each name, by index.
    named: BTreeMap<User, Vec<usize>>,
}

impl Journal {
    /// Reads the journal; lines that cannot be read (a crash in mid-write) are skipped.
    pub fn open(store: &Store) -> Self {
        let path = store.root().join("journal.jsonl");
        let text = fs::read_to_string(&path).unwrap_or_default();
        let lines: Vec<Line> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let user = |line: &Line| User { arm: line.arm.clone(), stage: line.stage.clone() };
        let latest = lines.iter().map(|line| (user(line), line.fingerprint.clone())).collect();
        let mut named: BTreeMap<User, Vec<usize>> = BTreeMap::new();
        lines.iter().enumerate().for_each(|(index, line)| named.entry(user(line)).or_default().push(index));
        Self { path, lines, latest, named }
    }

    /// Notes that a stage's artefact is in the store, for every name it has, where that is news.
    pub fn note(&mut self, run: &str, stage: &Stage) -> Result<(), StoreError> {
        let mut text = String::new();
        for user in &stage.users {
            if self.latest.get(user) == Some(&stage.fingerprint) {
                continue;
            }
            let line = Line {
                run: run.into(),
                arm: user.arm.clone(),
                stage: user.stage.clone(),
                kind: stage.kind,
                fingerprint: stage.fingerprint.clone(),
            };
            text.push_str(&serde_json::to_string(&line).expect("a line is plain data"));
            text.push('\n');
            self.latest.insert(user.clone(), stage.fingerprint.clone());
            self.named.entry(user.clone()).or_default().push(self.lines.len());
            self.lines.push(line);
        }
        if text.is_empty() {
            return Ok(());
        }
        let file = fs::File::options().create(true).append(true).open(&self.path);
        file.and_then(|mut file| file.write_all(text.as_bytes()))
            .map_err(|error| StoreError::writing(&self.path, error))
    }

    /// The present artefact of every named stage.
    pub fn present(&self) -> impl Iterator<Item = &Fingerprint> {
        self.latest.values()
    }

    /// Earlier artefacts under the names of a stage, the latest first, without its present one.
    fn earlier(&self, stage: &Stage) -> impl Iterator<Item = &Line> {
        let mut used: Vec<usize> =
            stage.users.iter().filter_map(|user| self.named.get(user)).flatten().copied().collect();
        used.sort_unstable();
        let other = |line: &&Line| line.kind == stage.kind && line.fingerprint != stage.fingerprint;
        used.into_iter().rev().map(|index| &self.lines[index]).filter(other)
    }
}

/// A store and its journal, as the plan sees them.
#[derive(Debug)]
pub struct Past<'a> {
    store: &'a Store,
    journal: Journal,
}

impl<'a> Past<'a> {
    /// The past of a store.
    pub fn of(store: &'a Store) -> Self {
        Self { store, journal: Journal::open(store) }
    }
}

impl History for Past<'_> {
    fn cached(&self, kind: StageKind, fingerprint: &Fingerprint) -> Cached {
        self.store.inspect(kind, fingerprint, Depth::Quick)
    }

    fn entry(&self, kind: StageKind, fingerprint: &Fingerprint) -> Option<Stage> {
        Some(self.store.manifest(kind, fingerprint).ok()??.stage)
    }

    fn earlier(&self, stage: &Stage) -> Option<Stage> {
        self.journal.earlier(stage).find_map(|line| self.entry(line.kind, &line.fingerprint))
    }

    fn previous(&self, stage: &Stage) -> Option<Previous> {
        if let Some(stage) = self.earlier(stage) {
            return Some(Previous { stage, named: true });
        }
        let others = self.store.keys(stage.kind).into_iter().filter(|key| *key != stage.fingerprint);
        let entries = others.take(NEAREST_LIMIT).filter_map(|key| self.entry(stage.kind, &key));
        let nearest = entries.min_by_key(|entry| why::distance(&entry.recipe, &stage.recipe))?;
        Some(Previous { stage: nearest, named: false })
    }
}
