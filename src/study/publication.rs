//! Publishes a report under the lock of its folder.
//!
//! The name is chosen again under the lock, as a concurrent run of the same spec with another `--set` may
//! have published its page meanwhile. The report is then rendered again under an available name.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::page_name::{self, Destination};
use super::{Study, origins};
use crate::exec::lease::Lease;
use crate::exec::lock::Wait;
use crate::exec::{self, StoreError, Workshop};
use crate::plan::{PlanError, StageKind};
use crate::report::publish::Publisher;

/// A report with its final name, and the lock of its folder.
pub struct Ready<'a> {
    /// The folder, locked for the lifetime of this value.
    pub publisher: Publisher<'a>,
    /// The name of its page.
    pub name: String,
    /// Its artefact in the store.
    pub artefact: PathBuf,
    /// The folder of reports.
    folder: &'a Path,
    /// The folder of the project.
    project: PathBuf,
    /// Protects an artefact that was rendered here from garbage collection.
    _lease: Option<Lease>,
}

impl Ready<'_> {
    /// Publishes the report and returns the path of its page. `tell` receives a warning for each file of the
    /// earlier report that was edited by hand and is kept as a copy.
    pub fn publish(&self, tell: &dyn Fn(&str)) -> Result<PathBuf, StoreError> {
        origins::note(self.folder, &self.name, &self.project)
            .map_err(|error| StoreError::publishing(self.folder, error))?;
        let publication = self.publisher.publish(&self.artefact, &self.name)?;
        publication.warnings().for_each(|warning| tell(&warning));
        Ok(publication.page)
    }
}

/// Why a report cannot be published.
#[derive(Debug, thiserror::Error)]
pub enum Unready {
    /// The store or the folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The report of the plan cannot be renamed.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Rendering was interrupted.
    #[error("interrupted")]
    Interrupted,
    /// Rendering failed; an event has the reason.
    #[error("the report cannot be rendered")]
    Failed,
}

/// Locks the folder of reports, and renders the report again if its page needs another name. `tell` receives
/// progress messages for the user.
pub fn ready<'a>(
    artefact: &Path,
    study: &Study,
    destination: Destination<'a>,
    workshop: &Workshop,
    tell: &dyn Fn(&str),
) -> Result<Ready<'a>, Unready> {
    let shown = destination.folder.display();
    let waits = |who: &str| tell(&format!("{who} is writing a report into {shown}; waiting for it"));
    let wait = Wait { interrupt: Some(workshop.interrupt), tell: Some(&waits) };
    let publisher = Publisher::lock(destination.folder, &wait)?;
    let (folder, project) = (destination.folder, study.project.clone());
    let choice = page_name::choice(study, destination);
    if choice.name == study.name {
        let (name, artefact) = (choice.name, artefact.to_owned());
        return Ok(Ready { publisher, name, artefact, folder, project, _lease: None });
    }
    tell(&choice.note.unwrap_or_default());
    let plan = study.plan.clone().reported_as(&choice.name)?;
    let reports = plan.stages().filter(|stage| stage.kind == StageKind::Report);
    let selected: BTreeSet<_> = reports.map(|stage| stage.fingerprint.clone()).collect();
    let settings =
        exec::Options { jobs: 1, keep_going: true, selected, reasons: Default::default(), single: None };
    let outcome = exec::run(&Workshop { plan: &plan, ..*workshop }, &settings)?;
    match outcome.report {
        Some(artefact) => {
            let name = choice.name;
            Ok(Ready { publisher, name, artefact, folder, project, _lease: outcome.lease })
        }
        None if outcome.interrupted => Err(Unready::Interrupted),
        None => Err(Unready::Failed),
    }
}
