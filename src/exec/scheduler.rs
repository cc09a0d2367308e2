//! The local scheduler: runs the stages of a plan concurrently within a budget of cores.
//!
//! Stages start in the plan's order as soon as their inputs are available. Multi-threaded stages share the
//! budget evenly and adapt when it changes. The number of threads never affects results.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Scope;
use std::time::Duration;

use serde_json::json;

use super::events::Event;
use super::fault::StoreError;
use super::journal::Journal;
use super::lease::Lease;
use super::manifest::{self, Depth};
use super::marker::{self, Identity};
use super::meter::Meter;
use super::perform::{Ending, Order, Workshop};
use super::tensorboard;
use super::work::{Failure, Threads as Share, WorkError};
use crate::escape::shell;
use crate::plan::stage::Threads;
use crate::plan::{Fingerprint, Stage, StageKind};

/// Interval at which the scheduler checks for interruption and divides CPU time.
const POLL: Duration = Duration::from_millis(100);

/// How to run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The budget: maximum number of threads, and of concurrent stages.
    pub jobs: usize,
    /// Whether other arms continue after a failure.
    pub keep_going: bool,
    /// The stages that may run.
    pub selected: BTreeSet<Fingerprint>,
    /// Why each stage runs, for its first event.
    pub reasons: BTreeMap<Fingerprint, Vec<String>>,
    /// The saved plan of which the user runs a single stage, with `specforge stage`.
    pub single: Option<PathBuf>,
}

/// The result of a run.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Stages that ran.
    pub worked: Vec<Fingerprint>,
    /// Stages that were in the store already.
    pub cached: Vec<Fingerprint>,
    /// Stages that failed.
    pub failures: Vec<Failure>,
    /// Stages that could not start because an input is missing.
    pub skipped: Vec<Fingerprint>,
    /// Whether the user interrupted the run.
    pub interrupted: bool,
    /// The report's folder in the store.
    pub report: Option<PathBuf>,
    /// Protects the run's artefacts from `cache gc` while the outcome is in use.
    pub lease: Option<Lease>,
}

/// State of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    Waiting,
    Running,
    Done,
    Failed,
    Skipped,
}

/// A stage that runs.
struct Running {
    share: Share,
    most: Threads,
}

/// A stage that ended.
struct Message {
    /// The stage of the plan.
    key: Fingerprint,
    /// What was made: the same, or a report on some of its inputs.
    made: Fingerprint,
    ending: Ending,
}

/// Runs the selected stages of the plan. Interrupting a wait for the store counts as interrupting the run.
pub fn run(workshop: &Workshop, options: &Options) -> Result<Outcome, StoreError> {
    match work(workshop, options) {
        Err(StoreError::Interrupted) => Ok(Outcome { interrupted: true, ..Outcome::default() }),
        ended => ended,
    }
}

fn work(workshop: &Workshop, options: &Options) -> Result<Outcome, StoreError> {
    let store = workshop.store;
    let lease = || workshop.waiting(|wait| store.lease(workshop.plan, wait));
    // Lease before inspecting the store, so that the artefacts found are not removed. If everything is
    // cached, the store may be read-only.
    let early = match marker::identity(store.root())? {
        Identity::Marked | Identity::Unmarked => match lease() {
            Err(StoreError::Interrupted) => return Err(StoreError::Interrupted),
            lease => lease.ok(),
        },
        Identity::Absent | Identity::Other { .. } => None,
    };
    let mut board = Board::new(workshop, options)?;
    let works = board.standing.values().any(|standing| *standing == Standing::Waiting);
    if works {
        store.prepare()?;
    }
    board.outcome.lease = match early {
        None if works => Some(lease()?),
        early => early,
    };
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        loop {
            board.start_ready(scope, &sender);
            if board.running.is_empty() {
                return Ok(());
            }
            match receiver.recv_timeout(POLL) {
                // The scope waits for its stages: stop them, as their results can no longer be recorded.
                Ok(message) => board.finish(message).inspect_err(|_| workshop.interrupt.set())?,
                Err(RecvTimeoutError::Timeout) => board.tick(),
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    })?;
    Ok(board.close())
}

/// The state of all stages of a run.
struct Board<'a> {
    workshop: &'a Workshop<'a>,
    options: &'a Options,
    journal: Journal,
    run: String,
    standing: BTreeMap<Fingerprint, Standing>,
    running: BTreeMap<Fingerprint, Running>,
    meter: Arc<Mutex<Meter>>,
    outcome: Outcome,
    told: bool,
}

impl<'a> Board<'a> {
    /// Inspects the store: a stage is done if its artefact is whole. Every byte of artefacts that other
    /// stages will read is checked.
    fn new(workshop: &'a Workshop<'a>, options: &'a Options) -> Result<Self, StoreError> {
        let mut board = Self {
            workshop,
            options,
            journal: Journal::open(workshop.store)?,
            run: format!("{}.{}", manifest::now(), std::process::id()),
            standing: BTreeMap::new(),
            running: BTreeMap::new(),
            meter: Arc::new(Mutex::new(Meter::start())),
            outcome: Outcome::default(),
            told: false,
        };
        let (mut read, mut continued) = (BTreeSet::new(), BTreeSet::new());
        for stage in workshop.plan.stages().rev() {
            let depth = if read.contains(&stage.fingerprint) { Depth::Full } else { Depth::Quick };
            let is_selected = options.selected.contains(&stage.fingerprint);
            let is_there = workshop.settle(stage, depth, is_selected)?;
            let is_remade = continued.contains(&stage.fingerprint) && is_selected;
            let is_there = is_there && !(is_remade && workshop.discard_reduced(stage)?);
            let standing = match is_there {
                true => Standing::Done,
                false if is_selected => Standing::Waiting,
                false => Standing::Skipped,
            };
            if standing == Standing::Waiting {
                read.extend(stage.recipe.inputs.values().cloned());
            }
            if standing == Standing::Waiting && stage.kind != StageKind::Report {
                continued.extend(stage.recipe.inputs.values().cloned());
            }
            board.standing.insert(stage.fingerprint.clone(), standing);
        }
        for stage in workshop.plan.stages() {
            if board.standing[&stage.fingerprint] == Standing::Done {
                board.done(stage, None)?;
            }
        }
        Ok(board)
    }

    /// Records that an artefact is available: from before (`None`), or made in this wall time in s.
    fn done(&mut self, stage: &Stage, wall: Option<f64>) -> Result<(), StoreError> {
        self.standing.insert(stage.fingerprint.clone(), Standing::Done);
        let scope = self.workshop.plan.scope();
        let noted = self.workshop.waiting(|wait| self.journal.note(&self.run, &scope, stage, wait));
        if wall.is_some() || matches!(noted, Err(StoreError::Interrupted)) {
            noted?;
        }
        self.note_report(stage, &stage.fingerprint);
        // Nothing needs the links, and a store that is only read cannot have new ones.
        let _ = tensorboard::finished(self.workshop.store, self.workshop.plan, stage);
        self.count(stage, wall);
        Ok(())
    }

    fn count(&mut self, stage: &Stage, wall: Option<f64>) {
        let list = if wall.is_some() { &mut self.outcome.worked } else { &mut self.outcome.cached };
        list.push(stage.fingerprint.clone());
        let (label, key) = (self.workshop.plan.label(stage), stage.fingerprint.to_string());
        let (cached, wall_s) = (wall.is_none(), wall.unwrap_or(0.0));
        self.workshop.events.emit(Event::StageFinished { stage: label, key, cached, wall_s });
    }

    fn note_report(&mut self, stage: &Stage, key: &Fingerprint) {
        if stage.kind == StageKind::Report {
            self.outcome.report = Some(self.workshop.store.folder(stage.kind, key));
        }
    }

    /// Starts stages that are ready, in the plan's order, as far as the budget allows.
    fn start_ready<'scope>(&mut self, scope: &'scope Scope<'scope, '_>, sender: &mpsc::Sender<Message>)
    where
        'a: 'scope,
    {
        self.skip_hopeless();
        let failed = !self.options.keep_going && !self.outcome.failures.is_empty();
        if failed || self.workshop.interrupt.is_set() {
            return;
        }
        let plan = self.workshop.plan;
        let waiting = plan.stages().filter(|stage| self.standing[&stage.fingerprint] == Standing::Waiting);
        let ready = waiting.filter(|stage| self.is_ready(stage));
        let room = self.options.jobs.max(1).saturating_sub(self.running.len());
        let chosen: Vec<&Stage> = ready.take(room).collect();
        if chosen.is_empty() {
            return;
        }
        self.share_time();
        for stage in &chosen {
            let running = Running { share: Share::new(1), most: stage.kind.facts().threads };
            self.running.insert(stage.fingerprint.clone(), running);
            self.standing.insert(stage.fingerprint.clone(), Standing::Running);
        }
        // Before the stages start, because a stage may ask for its share only once.
        self.rebalance();
        for stage in chosen {
            self.start(stage, scope, sender.clone());
        }
    }

    /// Skips stages whose inputs will never be made. A report uses the inputs that exist.
    fn skip_hopeless(&mut self) {
        for stage in self.workshop.plan.stages().filter(|stage| stage.kind != StageKind::Report) {
            let lost = |key: &Fingerprint| matches!(self.standing[key], Standing::Failed | Standing::Skipped);
            if self.standing[&stage.fingerprint] == Standing::Waiting
                && stage.recipe.inputs.values().any(lost)
            {
                self.standing.insert(stage.fingerprint.clone(), Standing::Skipped);
                self.outcome.skipped.push(stage.fingerprint.clone());
                self.tell_unselected_input(stage);
            }
        }
    }

    /// Reports a stage that cannot start although nothing failed, because its input was not selected. Counts
    /// as a failure of its own, not as the consequence of another.
    fn tell_unselected_input(&mut self, stage: &Stage) {
        let plan = self.workshop.plan;
        let absent = |key: &&Fingerprint| {
            self.standing[*key] == Standing::Skipped && !self.options.selected.contains(*key)
        };
        let Some(input) = stage.recipe.inputs.values().find(absent).and_then(|key| plan.stage(key)) else {
            return;
        };
        let error = WorkError::Failed {
            code: None,
            message: format!("its input `{}` is not in the store and was not selected", plan.label(input)),
            help: Some(match &self.options.single {
                None => "run without `--only` and `--from`, or select the input too".to_owned(),
                Some(file) => format!(
                    "run it first: `specforge stage {} --plan {}`",
                    input.fingerprint.short(),
                    shell::argument(file)
                ),
            }),
        };
        self.failed(stage, self.workshop.failure(stage, &error));
    }

    fn failed(&mut self, stage: &Stage, failure: Failure) {
        let Failure { stage: label, code, message, help, .. } = failure.clone();
        let key = stage.fingerprint.to_string();
        self.workshop.events.emit(Event::StageFailed { stage: label, key, code, message, help });
        self.outcome.failures.push(failure);
    }

    fn is_ready(&self, stage: &Stage) -> bool {
        let mut inputs = stage.recipe.inputs.values().map(|key| self.standing[key]);
        match stage.kind {
            StageKind::Report => {
                inputs.all(|standing| !matches!(standing, Standing::Waiting | Standing::Running))
            }
            _ => inputs.all(|standing| standing == Standing::Done),
        }
    }

    fn start<'scope>(
        &mut self,
        stage: &Stage,
        scope: &'scope Scope<'scope, '_>,
        sender: mpsc::Sender<Message>,
    ) where
        'a: 'scope,
    {
        let workshop = self.workshop;
        let key = stage.fingerprint.clone();
        workshop.events.emit(Event::StageStarted {
            stage: workshop.plan.label(stage),
            key: key.to_string(),
            kind: stage.kind.name().into(),
            reasons: self.options.reasons.get(&key).cloned().unwrap_or_default(),
        });
        let failures =
            if stage.kind == StageKind::Report { self.outcome.failures.clone() } else { Vec::new() };
        let there = |key: &Fingerprint| self.standing[key] == Standing::Done;
        let stage = partial(stage, there, &failures);
        let inputs = stage.recipe.inputs.iter();
        let inputs = inputs
            .filter_map(|(role, key)| Some((role.clone(), (workshop.plan.stage(key)?.kind, key.clone()))));
        let inputs = inputs.collect();
        let (threads, meter) = (self.running[&key].share.clone(), self.meter.clone());
        scope.spawn(move || {
            let cpu = || lock(&meter).spent(&key);
            let order = Order { stage: &stage, inputs, threads, failures: &failures, cpu: &cpu };
            let ending = workshop.perform(&order);
            // The receiver outlives every stage.
            let _ = sender.send(Message { key, made: stage.fingerprint.clone(), ending });
        });
    }

    fn finish(&mut self, Message { key, made, ending }: Message) -> Result<(), StoreError> {
        self.share_time();
        self.running.remove(&key);
        self.rebalance();
        let stage = self.workshop.plan.stage(&key).expect("only stages of the plan are started");
        match ending {
            Ending::Cached | Ending::Worked(_) => {
                let wall = if let Ending::Worked(wall) = ending { Some(wall) } else { None };
                if made == key {
                    return self.done(stage, wall);
                }
                // A report on some of its inputs: shown, but not recorded as the stage's artefact.
                self.standing.insert(key, Standing::Done);
                self.note_report(stage, &made);
                self.count(stage, wall);
            }
            Ending::Interrupted => {
                self.outcome.interrupted = true;
                self.standing.insert(key, Standing::Skipped);
            }
            Ending::Failed(failure) => {
                self.standing.insert(key, Standing::Failed);
                self.failed(stage, failure);
            }
        }
        Ok(())
    }

    /// Housekeeping at each poll in which no stage ended.
    fn tick(&mut self) {
        self.share_time();
        if self.workshop.interrupt.is_set() && !std::mem::replace(&mut self.told, true) {
            let message =
                "interrupted: writing checkpoints, then stopping; press Ctrl-C again to stop at once".into();
            self.workshop.events.emit(Event::Warning { stage: None, code: None, message, help: None });
        }
    }

    fn share_time(&self) {
        let running: Vec<_> =
            self.running.iter().map(|(key, running)| (key.clone(), running.share.now())).collect();
        lock(&self.meter).share(&running);
    }

    /// Single-threaded stages get one thread; the others share the rest evenly, the first get the remainder.
    fn rebalance(&self) {
        let greedy: Vec<&Running> =
            self.running.values().filter(|running| running.most == Threads::Max).collect();
        let rest = self.options.jobs.max(1).saturating_sub(self.running.len() - greedy.len());
        for (index, running) in greedy.iter().enumerate() {
            running.share.set(rest / greedy.len() + usize::from(index < rest % greedy.len()));
        }
    }

    fn close(mut self) -> Outcome {
        let waiting = self.standing.values().any(|standing| *standing == Standing::Waiting);
        self.outcome.interrupted |= waiting && self.workshop.interrupt.is_set();
        self.outcome
    }
}

fn lock(meter: &Mutex<Meter>) -> MutexGuard<'_, Meter> {
    meter.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A report with missing inputs is a different stage, because it depends on the inputs that exist and on what
/// failed. All other stages are unchanged.
fn partial(stage: &Stage, there: impl Fn(&Fingerprint) -> bool, failures: &[Failure]) -> Stage {
    let mut stage = stage.clone();
    if stage.recipe.inputs.values().all(&there) {
        return stage;
    }
    stage.recipe.inputs.retain(|_, key| there(key));
    stage.recipe.content["failures"] = json!(failures);
    stage.fingerprint = stage.recipe.fingerprint();
    stage
}
