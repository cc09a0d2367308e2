//! Publishing a report under the lock of its folder.
//!
//! Its name is chosen again there: a run of the same spec with another `--set`, side by side with this one,
//! may have published its page in the meantime. The report is then rendered once more under the name that is
//! left for it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::comparison::Comparison;
use super::{Exit, Global, output, page_name, run};
use crate::exec::lease::Lease;
use crate::exec::lock::Wait;
use crate::exec::{self, Workshop};
use crate::plan::StageKind;
use crate::report::publish::Publisher;

/// Where a report goes.
#[derive(Clone, Copy, Debug)]
pub struct Destination<'a> {
    /// The folder of reports.
    pub folder: &'a Path,
    /// The name of the spec, which its report has where no other page has it.
    pub own: &'a str,
}

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

/// Locks the folder of reports, and renders the report again if its page must have another name than it was
/// rendered with. `Err` is the exit code; everything has been said then.
pub fn ready<'a>(
    artefact: &Path,
    comparison: &Comparison,
    destination: Destination<'a>,
    workshop: &Workshop,
    global: &Global,
) -> Result<Ready<'a>, Exit> {
    let shown = destination.folder.display();
    let tell =
        |who: &str| output::note(global, &format!("{who} is writing a report into {shown}; waiting for it"));
    let wait = Wait { interrupt: Some(workshop.interrupt), tell: Some(&tell) };
    let publisher =
        Publisher::lock(destination.folder, &wait).map_err(|error| run::complain(global, &error))?;
    let choice = page_name::choice(comparison, destination);
    if choice.name == comparison.name {
        let (name, artefact) = (choice.name, artefact.to_owned());
        return Ok(Ready { publisher, name, artefact, _lease: None });
    }
    output::note(global, &choice.note.unwrap_or_default());
    let plan = page_name::renamed(&comparison.plan, &choice.name, global)?;
    let reports = plan.stages().filter(|stage| stage.kind == StageKind::Report);
    let selected: BTreeSet<_> = reports.map(|stage| stage.fingerprint.clone()).collect();
    let settings = exec::Options { jobs: 1, keep_going: true, selected, reasons: Default::default() };
    let outcome = exec::run(&Workshop { plan: &plan, ..*workshop }, &settings);
    let outcome = outcome.map_err(|error| run::complain(global, &error))?;
    match outcome.report {
        Some(artefact) => Ok(Ready { publisher, name: choice.name, artefact, _lease: outcome.lease }),
        // What failed has been told as an event.
        None if outcome.interrupted => Err(Exit::Interrupted),
        None => Err(Exit::StageFailed),
    }
}
