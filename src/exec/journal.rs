//! The journal: the artefacts that each named stage has had, run by run. With it, `why` compares a stage with
//! its own previous version and not with an unrelated one of the same kind. It also records what is in use
//! and which attempts ended their process.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::fault::StoreError;
use super::interrupt::Interrupt;
use super::line_file::{Contents, Health, LineFile};
use super::lock::Wait;
use super::manifest::Depth;
use super::store::Store;
use crate::plan::why::{self, Previous};
use crate::plan::{Cached, Fingerprint, History, Plan, Stage, StageKind, User};

/// How many artefacts of a kind are searched for the most similar one.
const NEAREST_LIMIT: usize = 64;

/// One line of the journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The run's identifier.
    pub run: String,
    /// What the arm belongs to ([`Plan::scope`]).
    pub scope: String,
    /// The arm.
    pub arm: String,
    /// The stage's name in that arm.
    pub stage: String,
    /// The stage's kind.
    pub kind: StageKind,
    /// The artefact.
    pub fingerprint: Fingerprint,
}

/// A line about an attempt at a stage that ended its process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CrashLine {
    /// The stage's name for people; `the run` where it is unknown.
    pub crash: String,
    /// The stage's key; empty where it is unknown.
    pub key: String,
    /// The diagnostic's code.
    pub code: String,
    /// What ended the process.
    pub message: String,
    /// When it happened, in UTC.
    pub time: String,
    /// The process ID.
    pub process: u32,
}

impl CrashLine {
    /// Appends the line to the journal of the store in this folder. An ending process waits only briefly for
    /// the journal's lock, which another of its own threads may hold.
    pub fn note(&self, root: &Path) -> Result<(), StoreError> {
        const TRIES: usize = 20;
        let ended = Interrupt::default();
        ended.set();
        let (wait, news) = (Wait { interrupt: Some(&ended), ..Wait::default() }, [text(self)]);
        for _ in 1..TRIES {
            match LineFile::new(root).append(&news, &wait) {
                Err(StoreError::Interrupted) => std::thread::sleep(Duration::from_millis(50)),
                noted => return noted,
            }
        }
        LineFile::new(root).append(&news, &wait)
    }
}

/// A line of the journal.
fn text(line: &impl Serialize) -> String {
    serde_json::to_string(line).expect("a line is plain data")
}

impl Line {
    fn name(&self) -> Name {
        (self.scope.clone(), User { arm: self.arm.clone(), stage: self.stage.clone() })
    }
}

/// A stage's name within its scope.
type Name = (String, User);

/// The journal of a store.
#[derive(Debug, Default)]
pub struct Journal {
    file: LineFile,
    health: Health,
    lines: Vec<Line>,
    crashes: Vec<CrashLine>,
    latest: BTreeMap<Name, Fingerprint>,
    /// Indices of the lines of each name.
    named: BTreeMap<Name, Vec<usize>>,
}

impl Journal {
    /// Reads the journal. Unreadable lines are skipped and reported by [`Journal::health`]; it is an error if
    /// the journal exists and cannot be read at all.
    pub fn open(store: &Store) -> Result<Self, StoreError> {
        let file = LineFile::new(store.root());
        let Contents { lines: texts, health, .. } = file.read()?;
        let lines: Vec<Line> = texts.iter().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let crashes = texts.iter().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let latest = lines.iter().map(|line| (line.name(), line.fingerprint.clone())).collect();
        let mut named: BTreeMap<Name, Vec<usize>> = BTreeMap::new();
        lines.iter().enumerate().for_each(|(index, line)| named.entry(line.name()).or_default().push(index));
        Ok(Self { file, health, lines, crashes, latest, named })
    }

    /// Whether the journal is complete and unchanged.
    pub fn health(&self) -> &Health {
        &self.health
    }

    /// Records that a stage's artefact is in the store, under every name that the stage has in this scope,
    /// unless the journal says so already.
    pub fn note(&mut self, run: &str, scope: &str, stage: &Stage, wait: &Wait) -> Result<(), StoreError> {
        let mut news = Vec::new();
        for user in &stage.users {
            let name = (scope.to_owned(), user.clone());
            if self.latest.get(&name) == Some(&stage.fingerprint) {
                continue;
            }
            let line = Line {
                run: run.into(),
                scope: scope.into(),
                arm: user.arm.clone(),
                stage: user.stage.clone(),
                kind: stage.kind,
                fingerprint: stage.fingerprint.clone(),
            };
            news.push(text(&line));
            self.latest.insert(name.clone(), stage.fingerprint.clone());
            self.named.entry(name).or_default().push(self.lines.len());
            self.lines.push(line);
        }
        if news.is_empty() { Ok(()) } else { self.file.append(&news, wait) }
    }

    /// Moves an incomplete journal aside and writes a complete one from its readable lines.
    pub fn mend(&self, aside: &Path, wait: &Wait) -> Result<(), StoreError> {
        let lines = self.lines.iter().map(text).chain(self.crashes.iter().map(text));
        self.file.replace(aside, &lines.collect::<Vec<_>>(), wait)
    }

    /// The attempts at a stage that ended their process, earliest first.
    pub fn crashes<'a>(&'a self, key: &'a Fingerprint) -> impl Iterator<Item = &'a CrashLine> {
        self.crashes.iter().filter(|crash| crash.key == key.as_str())
    }

    /// All artefacts that the journal names.
    pub fn known(&self) -> impl Iterator<Item = &Fingerprint> {
        self.lines.iter().map(|line| &line.fingerprint)
    }

    /// The current artefact of every named stage.
    pub fn present(&self) -> impl Iterator<Item = &Fingerprint> {
        self.latest.values()
    }

    /// Earlier artefacts under the names of a stage in that scope, latest first, without the current one.
    fn earlier(&self, scope: &str, stage: &Stage) -> impl Iterator<Item = &Line> {
        let mut used: Vec<usize> = stage
            .users
            .iter()
            .filter_map(|user| self.named.get(&(scope.into(), user.clone())))
            .flatten()
            .copied()
            .collect();
        used.sort_unstable();
        let other = |line: &&Line| line.kind == stage.kind && line.fingerprint != stage.fingerprint;
        used.into_iter().rev().map(|index| &self.lines[index]).filter(other)
    }
}

/// A store and its journal, as a plan uses them.
#[derive(Debug)]
pub struct Past<'a> {
    store: &'a Store,
    journal: Journal,
    scope: String,
}

impl<'a> Past<'a> {
    /// The history of a plan's stages in a store; without a readable journal it names no stages.
    pub fn of(store: &'a Store, plan: &Plan) -> Self {
        Self { store, journal: Journal::open(store).unwrap_or_default(), scope: plan.scope() }
    }

    /// The attempts at a stage that ended their process, earliest first.
    pub fn crashes(&self, key: &Fingerprint) -> Vec<CrashLine> {
        self.journal.crashes(key).cloned().collect()
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
        self.journal.earlier(&self.scope, stage).find_map(|line| self.entry(line.kind, &line.fingerprint))
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
