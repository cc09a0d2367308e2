//! From specs, a suite or a saved plan to a plan with its project: loads, checks and lowers everything.
//! Nothing here prints or ends the process: a program that embeds specforge reads the diagnostics from the
//! log.

pub mod compared;
pub mod files;
pub mod findings;
pub mod origins;
pub mod out_of_date;
pub mod page;
pub mod page_name;
pub mod plan;
pub mod publication;
pub mod saved;
pub mod spec;
pub mod standing;
pub mod suite;
pub mod works;

use std::path::PathBuf;

pub use self::findings::{Findings, Log};
use self::page_name::Destination;
use self::publication::Unready;
use crate::exec::{self, Event, Events, Interrupt, Store, StoreError, Workshop};
use crate::plan::Plan;
use crate::report::paths;
use crate::spec::LoadOptions;

/// A plan with its project.
#[derive(Clone, Debug)]
pub struct Study {
    /// The plan.
    pub plan: Plan,
    /// The name of the report.
    pub name: String,
    /// The folder of `reports/` and `.specforge/`.
    pub project: PathBuf,
    /// The available profiles; empty for a plan from a file.
    pub profiles: Vec<String>,
}

/// Why a plan could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The files have errors, which are in the log.
    #[error("the specs have errors")]
    Invalid,
    /// The files cannot be planned together, or not with these options.
    #[error("{message}")]
    Usage {
        /// What is wrong.
        message: String,
        /// How to fix it.
        advice: String,
    },
}

impl Study {
    /// Reads, checks and lowers files: one or more specs with those they compare themselves with, one suite,
    /// or one saved plan. The log receives all diagnostics, including those of a valid study.
    pub fn read(files: &[PathBuf], options: &LoadOptions, log: &mut Log) -> Result<Self, Refusal> {
        match files {
            [file] if saved::is_plan(file) && options.varies() => Err(Refusal::Usage {
                message: format!("`--profile` and `--set` vary a spec, and {} is a plan", file.display()),
                advice: "name them when the plan is written: `specforge plan SPEC --profile NAME --save \
                    PLAN.json`"
                    .to_owned(),
            }),
            [file] if saved::is_plan(file) => saved::read(file, log),
            [file] if files::is_suite(file) => suite::read(file, options, log),
            files => match files.iter().find(|file| files::is_suite(file)) {
                Some(suite) => Err(Refusal::Usage {
                    message: format!("{} is a suite, which is planned by itself", suite.display()),
                    advice: "name one suite, or several specs".to_owned(),
                }),
                None => spec::read(files, options, log),
            },
        }
    }

    /// The store: the given folder, or `.specforge` in the project's folder. `Err` if its marker is damaged
    /// or has another layout, or if the folder is neither a store nor empty.
    pub fn store(&self, chosen: Option<PathBuf>) -> Result<Store, StoreError> {
        let store = Store::at(chosen.unwrap_or_else(|| self.project.join(".specforge")));
        store.identity()?;
        Ok(store)
    }

    /// The default folder of the page: its path below `reports/` mirrors that of the (first) spec below
    /// `specs/`.
    pub fn reports(&self) -> PathBuf {
        let place = self.plan.arms.first().map_or("", |arm| arm.request.place.as_str());
        self.project.join("reports").join(paths::page_folder(place))
    }

    /// Runs all stages that are missing from the store, at most `jobs` at once, and publishes the report in
    /// [`Study::reports`]. Returns the path of its page; `None` if a stage failed or the run was interrupted,
    /// which events report.
    pub fn run(
        &self,
        store: &Store,
        jobs: usize,
        events: &dyn Events,
        interrupt: &Interrupt,
    ) -> Result<Option<PathBuf>, Unready> {
        let works = works::works(self);
        let workshop = Workshop { plan: &self.plan, store, works: &works, events, interrupt };
        let selected = self.plan.stages().map(|stage| stage.fingerprint.clone()).collect();
        let settings =
            exec::Options { jobs, keep_going: true, selected, reasons: Default::default(), single: None };
        let outcome = exec::run(&workshop, &settings)?;
        let is_whole = outcome.failures.is_empty() && outcome.skipped.is_empty() && !outcome.interrupted;
        let Some(artefact) = outcome.report.as_ref().filter(|_| is_whole) else { return Ok(None) };
        let folder = self.reports();
        let destination = Destination { folder: &folder, own: &self.name };
        let ready = publication::ready(artefact, self, destination, &workshop, &|_| ())?;
        let warn = |text: &str| {
            let message = text.to_owned();
            events.emit(Event::Warning { stage: None, code: None, message, help: None });
        };
        Ok(Some(ready.publish(&warn)?))
    }
}
