//! Publishing a report under the lock of its folder.
//!
//! Its name is chosen again there: a run of the same spec with another `--set`, side by side with this one,
//! may have published its page in the meantime. The report is then rendered once more under the name that is
//! left for it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::Study;
use super::page_name::{self, Destination};
use crate::exec::lease::Lease;
use crate::exec::lock::Wait;
use crate::exec::{self, StoreError, Workshop};
use crate::plan::{PlanError, StageKind};
use crate::report::publish::Publisher;

/// A report under the name that it is published with, and the lock of its folder.
pub struct Ready<'a> {
    /// The folder, for nobody else as long as this lives.
    pub publisher: Publisher<'a>,
    /// The name of its page.
    pub name: String,
    /// Its artefact in the store.
    pub artefact: PathBuf,
    /// Keeps an artefact that was rendered here from being cleaned away.
    _lease: Option<Lease>,
}

/// Why a report is not ready to be published.
#[derive(Debug, thiserror::Error)]
pub enum Unready {
    /// The store or the folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The plan cannot have another name of its report.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Rendering it again was interrupted.
    #[error("interrupted")]
    Interrupted,
    /// Rendering it again failed; an event said why.
    #[error("the report cannot be rendered")]
    Failed,
}

/// Locks the folder of reports, and renders the report again if its page must have another name than it was
/// rendered with. `tell` gets sentences for the user while that takes time.
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
    let choice = page_name::choice(study, destination);
    if choice.name == study.name {
        let (name, artefact) = (choice.name, artefact.to_owned());
        return Ok(Ready { publisher, name, artefact, _lease: None });
    }
    tell(&choice.note.unwrap_or_default());
    let plan = study.plan.clone().reported_as(&choice.name)?;
    let reports = plan.stages().filter(|stage| stage.kind == StageKind::Report);
    let selected: BTreeSet<_> = reports.map(|stage| stage.fingerprint.clone()).collect();
    let settings = exec::Options { jobs: 1, keep_going: true, selected, reasons: Default::default() };
    let outcome = exec::run(&Workshop { plan: &plan, ..*workshop }, &settings)?;
    match outcome.report {
        Some(artefact) => Ok(Ready { publisher, name: choice.name, artefact, _lease: outcome.lease }),
        None if outcome.interrupted => Err(Unready::Interrupted),
        None => Err(Unready::Failed),
    }
}
