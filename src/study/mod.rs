//! From the files of specs, of a suite or of a saved plan to a plan with its project: everything is loaded,
//! checked and lowered. Nothing here prints or ends the process: a program that embeds specforge reads the
//! diagnostics from the log.

pub mod compared;
pub mod files;
pub mod findings;
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
use crate::exec::{self, Events, Interrupt, Store, StoreError, Workshop};
use crate::plan::Plan;
use crate::report::paths;
use crate::spec::LoadOptions;

/// A plan and where it belongs.
#[derive(Clone, Debug)]
pub struct Study {
    /// The plan.
    pub plan: Plan,
    /// The name of the report.
    pub name: String,
    /// The folder of `reports/` and `.specforge/`.
    pub project: PathBuf,
    /// The profiles that could have been chosen; none of a plan from a file.
    pub profiles: Vec<String>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The files have errors, which are in the log.
    #[error("the specs have errors")]
    Invalid,
    /// The files cannot be planned together, or not like this.
    #[error("{message}")]
    Usage {
        /// What is wrong.
        message: String,
        /// What to do.
        advice: String,
    },
}

impl Study {
    /// Reads, checks and lowers files: one or more specs with the specs that they compare themselves with,
    /// one suite, or one saved plan. The log has all diagnostics, also those of a study that can be run.
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

    /// The store: the folder that was chosen, or `.specforge` in the project's folder. `Err` when its mark is
    /// damaged or of another layout, or when the folder is not a store and not empty.
    pub fn store(&self, chosen: Option<PathBuf>) -> Result<Store, StoreError> {
        let store = Store::at(chosen.unwrap_or_else(|| self.project.join(".specforge")));
        store.identity()?;
        Ok(store)
    }

    /// The folder of the page, unless another one is chosen: below `reports/` as the (first) spec is below
    /// `specs/`.
    pub fn reports(&self) -> PathBuf {
        let place = self.plan.arms.first().map_or("", |arm| arm.request.place.as_str());
        self.project.join("reports").join(paths::page_folder(place))
    }

    /// Works on all stages that are not in the store, at most `jobs` at once, and publishes the report into
    /// [`Study::reports`]. With the path of its page; none when a stage failed or the run was interrupted,
    /// which the events say.
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
        let settings = exec::Options { jobs, keep_going: true, selected, reasons: Default::default() };
        let outcome = exec::run(&workshop, &settings)?;
        let is_whole = outcome.failures.is_empty() && outcome.skipped.is_empty() && !outcome.interrupted;
        let Some(artefact) = outcome.report.as_ref().filter(|_| is_whole) else { return Ok(None) };
        let folder = self.reports();
        let destination = Destination { folder: &folder, own: &self.name };
        let ready = publication::ready(artefact, self, destination, &workshop, &|_| ())?;
        Ok(Some(ready.publisher.publish(&ready.artefact, &ready.name)?))
    }
}
