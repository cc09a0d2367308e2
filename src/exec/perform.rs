//! Performs one stage, from lock to artefact: `run` does this for each stage, `stage` for one.

use std::collections::BTreeMap;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};

use super::effort::Meter;
use super::events::{Event, Events};
use super::fault::StoreError;
use super::interrupt::Interrupt;
use super::last_words;
use super::lock::Wait;
use super::manifest::{Depth, Provenance};
use super::shorter::{self, Cause};
use super::store::Store;
use super::tensorboard;
use super::work::{Failure, Job, Threads, WorkError, Works};
use crate::crash;
use crate::plan::{Cached, Fingerprint, Plan, Stage, StageKind};

/// What all stages of a run share.
pub struct Workshop<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The store.
    pub store: &'a Store,
    /// The implementation of each kind of stage.
    pub works: &'a Works,
    /// Receives the events.
    pub events: &'a dyn Events,
    /// Whether a stop was requested.
    pub interrupt: &'a Interrupt,
}

/// How a stage ended.
#[derive(Debug)]
pub enum Ending {
    /// The artefact was there already, or another run made it in the meantime.
    Cached,
    /// The artefact was made; wall time in s.
    Worked(f64),
    /// The user interrupted the stage.
    Interrupted,
    /// The stage failed.
    Failed(Failure),
}

/// A stage to perform and its resources.
pub struct Order<'a> {
    /// The stage.
    pub stage: &'a Stage,
    /// Its inputs by role.
    pub inputs: BTreeMap<String, (StageKind, Fingerprint)>,
    /// Its share of the machine.
    pub threads: Threads,
    /// For a report: the stages that failed.
    pub failures: &'a [Failure],
    /// Returns the CPU time that the stage has used so far, in s.
    pub cpu: &'a (dyn Fn() -> f64 + Sync),
}

impl Workshop<'_> {
    /// Makes a stage's artefact unless it exists. Takes the fingerprint's lock, so that of two runs one makes
    /// the artefact and the other waits and then finds it.
    pub fn perform(&self, order: &Order) -> Ending {
        match guarded(|| self.attempt(order)) {
            Ok(ending) => ending,
            Err(WorkError::Interrupted | WorkError::Store(StoreError::Interrupted)) => Ending::Interrupted,
            Err(error) => Ending::Failed(self.failure(order.stage, &error)),
        }
    }

    /// Emits a warning without a code.
    fn warn(&self, stage: Option<String>, message: String) {
        self.events.emit(Event::Warning { stage, code: None, message, help: None });
    }

    /// Runs something that may have to wait briefly while another process changes the store. Longer waits are
    /// reported and can be interrupted.
    pub fn waiting<T>(&self, wanted: impl FnOnce(&Wait) -> T) -> T {
        let root = self.store.root().display();
        let tell = |who: &str| self.warn(None, format!("{who} has locked the store {root}; waiting for it"));
        wanted(&Wait { interrupt: Some(self.interrupt), tell: Some(&tell) })
    }

    fn attempt(&self, order: &Order) -> Result<Ending, WorkError> {
        let stage = order.stage;
        let label = self.plan.label(stage);
        let tell = |who: &str| {
            self.warn(Some(label.clone()), format!("{who} is working on it; waiting for its result"))
        };
        let wait = Wait { interrupt: Some(self.interrupt), tell: Some(&tell) };
        let _lock = self.store.lock(&stage.fingerprint, &wait)?;
        if self.settle(stage, Depth::Full, true)? {
            return Ok(Ending::Cached);
        }
        let inputs = self.inputs(order)?;
        let scratch = self.store.scratch(&stage.fingerprint)?;
        let meter = Meter::begin(self.events, &scratch, order.cpu);
        self.tell_crash(&label, &scratch);
        self.continue_shorter(stage, &label, &scratch)?;
        if let Err(error) = tensorboard::running(self.store, self.plan, stage) {
            self.warn(Some(label.clone()), format!("TensorBoard's folder is not up to date: {error}"));
        }
        let draft = self.store.begin(stage)?;
        let job = Job {
            stage,
            label,
            plan: self.plan,
            fields: &stage.fields,
            inputs,
            output: draft.folder(),
            scratch: &scratch,
            threads: order.threads.clone(),
            events: &meter,
            interrupt: self.interrupt,
            failures: order.failures,
        };
        let worked = {
            let _working =
                crash::working(crash::Work { label: job.label.clone(), key: stage.fingerprint.to_string() });
            self.work(&job)
        };
        let (attempt, effort) = (meter.attempt(), meter.total());
        if let Err(error) = worked {
            // Why the stage ended matters more than an error in recording its cost.
            let _ = effort.keep(&scratch);
            return Err(error);
        }
        shorter::keep_record(&scratch, draft.folder())?;
        draft.commit(Provenance::now(effort))?;
        Ok(Ending::Worked(attempt.wall_s))
    }

    /// Gives a training without a checkpoint the final checkpoint of the longest shorter training with the
    /// same schedule. Reports it, and any that could not be continued.
    fn continue_shorter(&self, stage: &Stage, label: &str, scratch: &Path) -> Result<(), StoreError> {
        let shorter::Beginning { link, passed_over, unreadable } = shorter::lend(self.store, stage, scratch)?;
        let instead = match &link {
            Some(link) => format!("the training continues another one from {} samples", link.samples),
            None => "the training begins at its first sample".to_owned(),
        };
        for shorter::PassedOver { link, cause } in &passed_over {
            let name = format!("training {} of {} samples", link.fingerprint.short(), link.samples);
            match cause {
                Cause::Damaged(reason) => {
                    let path = self.store.folder(stage.kind, &link.fingerprint);
                    let message = format!(
                        "{name} cannot be continued: {} is damaged ({reason}); {instead}",
                        path.display()
                    );
                    self.warn_of_damage(
                        label,
                        message,
                        "run the shorter training again if you need it: it is moved aside and made anew",
                    );
                }
                Cause::Restored => {
                    let reason = "it was restored from a record, and records hold no checkpoint";
                    self.note(label, format!("{name} cannot be continued: {reason}; {instead}"));
                }
            }
        }
        for shorter::Unreadable { fingerprint, reason } in &unreadable {
            let (short, path) = (fingerprint.short(), self.store.folder(stage.kind, fingerprint));
            let message = format!(
                "whether training {short} is the beginning of this one cannot be said: {} is damaged \
                 ({reason}); {instead}",
                path.display()
            );
            self.warn_of_damage(
                label,
                message,
                "`specforge cache verify` lists what is damaged; what a run needs of it is made anew",
            );
        }
        if let Some(link) = link {
            self.note(
                label,
                format!("continues training {} from {} samples", link.fingerprint.short(), link.samples),
            );
        }
        Ok(())
    }

    fn warn_of_damage(&self, label: &str, message: String, help: &str) {
        let (stage, code) = (Some(label.to_owned()), Some("R0003".to_owned()));
        self.events.emit(Event::Warning { stage, code, message, help: Some(help.to_owned()) });
    }

    fn note(&self, label: &str, message: String) {
        self.events.emit(Event::Note { stage: label.to_owned(), message });
    }

    /// Reports that the last attempt at a stage ended the process, to explain why the stage starts again.
    fn tell_crash(&self, label: &str, scratch: &Path) {
        if let Some(reason) = last_words::of_last_attempt(scratch) {
            let (stage, code) = (Some(label.to_owned()), Some(last_words::CODE.to_owned()));
            let message = format!("its last attempt failed: {reason}");
            self.events.emit(Event::Warning { stage, code, message, help: None });
        }
    }

    /// Whether the artefact is there and whole. Warns of a damaged one. If this run makes it anew
    /// (`is_selected`), it is first moved aside; otherwise it stays where it is and is not used.
    pub fn settle(&self, stage: &Stage, depth: Depth, is_selected: bool) -> Result<bool, StoreError> {
        let (kind, key) = (stage.kind, &stage.fingerprint);
        let reason = match self.store.inspect(kind, key, depth) {
            Cached::Yes => return Ok(true),
            Cached::No => return Ok(false),
            Cached::Damaged(reason) => reason,
        };
        let damaged = format!("the stored artefact was damaged ({reason})");
        let (message, help) = if !is_selected {
            let message = format!("the stored artefact is damaged ({reason}), so it is not used");
            (message, Some("`specforge run` the same files: it is moved aside and made anew".to_owned()))
        } else if self.store.is_borrowed(kind, key) {
            (format!("{damaged}; made anew for this command only, as the store cannot be written"), None)
        } else {
            let place = self.store.quarantine(kind, key)?;
            (format!("{damaged}; moved to {} and made anew", place.display()), None)
        };
        let (stage, code) = (Some(self.plan.label(stage)), Some("R0003".into()));
        self.events.emit(Event::Warning { stage, code, message, help });
        Ok(false)
    }

    /// Removes an artefact that was restored without its weights, so that it is made again. Returns whether
    /// it was one.
    pub fn discard_reduced(&self, stage: &Stage) -> Result<bool, StoreError> {
        let manifest = self.store.manifest(stage.kind, &stage.fingerprint)?;
        if !manifest.is_some_and(|manifest| manifest.is_reduced()) {
            return Ok(false);
        }
        let folder = self.store.folder(stage.kind, &stage.fingerprint);
        std::fs::remove_dir_all(&folder).map_err(|error| StoreError::writing(&folder, error))?;
        let message =
            "it was restored from a record without its weights, which another stage needs; made anew".into();
        self.events.emit(Event::Warning {
            stage: Some(self.plan.label(stage)),
            code: None,
            message,
            help: None,
        });
        Ok(true)
    }

    /// The folders of the inputs, all of which must be in the store and whole.
    fn inputs(&self, order: &Order) -> Result<BTreeMap<String, PathBuf>, WorkError> {
        let mut folders = BTreeMap::new();
        for (role, (kind, key)) in &order.inputs {
            match self.store.inspect(*kind, key, Depth::Full) {
                Cached::Yes => {
                    folders.insert(role.clone(), self.store.folder(*kind, key));
                }
                Cached::No => {
                    return Err(WorkError::Failed {
                        code: None,
                        message: format!("its input `{role}` ({}) is not in the store", key.short()),
                        help: Some(format!("run the stage `{role}` first")),
                    });
                }
                Cached::Damaged(reason) => {
                    let path = self.store.folder(*kind, key);
                    return Err(StoreError::Damaged { path, reason }.into());
                }
            }
        }
        Ok(folders)
    }

    fn work(&self, job: &Job) -> Result<(), WorkError> {
        let kind = job.stage.kind;
        let Some(work) = self.works.get(&kind) else {
            return Err(WorkError::failed(format!(
                "this binary was built without the work of `{}`",
                kind.name()
            )));
        };
        guarded(|| work.run(job))
    }

    /// A failure for the report and the events.
    pub fn failure(&self, stage: &Stage, error: &WorkError) -> Failure {
        let (code, help) = error.advice();
        Failure {
            stage: self.plan.label(stage),
            arms: stage.users.iter().map(|user| user.arm.clone()).collect(),
            code: code.map(Into::into),
            message: error.to_string(),
            help,
        }
    }
}

/// Panic messages of libtorch's allocators and of the system when memory or threads run out.
const EXHAUSTED: [&str; 7] = [
    "failed to spawn thread",
    "annot allocate memory",
    "can't allocate memory",
    "not enough memory",
    "out of memory",
    "bad_alloc",
    "Resource temporarily unavailable",
];

/// Turns a panic into a failure, so that the run can report it.
fn guarded<T>(work: impl FnOnce() -> Result<T, WorkError>) -> Result<T, WorkError> {
    std::panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        if EXHAUSTED.iter().any(|words| text.contains(words)) {
            return Err(WorkError::coded(
                last_words::CODE,
                format!("memory or threads ran out: {text}"),
                last_words::HELP,
            ));
        }
        Err(WorkError::Failed {
            code: None,
            message: format!("a bug in specforge stopped the stage: {text}"),
            help: Some("please report it with the spec and this message".into()),
        })
    })
}
