//! Finds pages of suites whose claims were changed after the page was rendered. Needs the suites, not the
//! store.

use std::path::{Path, PathBuf};

use super::files::is_suite;
use super::standing::{self, Recorded};
use crate::check;
use crate::report::claim;
use crate::report::sidecar::Sidecar;
use crate::spec::Claim;

/// How the claims of a page differ from those of its suite as it is now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfDate {
    /// The suite.
    pub suite: PathBuf,
    /// What differs.
    pub reason: String,
    /// How to fix it.
    pub fix: String,
}

/// Compares the verdicts of a page with the claims of its suite under the page's own options. `None` if they
/// are those of the page, if the page is of no suite, and if its suite is no longer there.
pub fn claims(report: &Sidecar) -> Option<OutOfDate> {
    let Recorded { files, options } = standing::recorded(report)?;
    let [suite] = files.as_slice() else { return None };
    if !suite.is_file() || !is_suite(suite) {
        return None;
    }
    let checked = check::suite(suite, &options);
    if checked.sink.has_errors() {
        let reason =
            "its suite has errors now, so it is unknown whether its claims are still those".to_owned();
        let fix = format!("correct the suite: `specforge check {}`", suite.display());
        return Some(OutOfDate { suite: suite.clone(), reason, fix });
    }
    let is_known = |claim: &Claim| report.claims.iter().any(|judged| claim::is_of(judged, claim));
    let is_there = |id: &str| checked.claims.iter().any(|claim| claim.id == id);
    let changed = checked.claims.iter().filter(|claim| !is_known(claim)).map(|claim| claim.id.as_str());
    let gone = report.claims.iter().map(|judged| judged.id.as_str()).filter(|id| !is_there(id));
    let names: Vec<String> = changed.chain(gone).map(|id| format!("`{id}`")).collect();
    if names.is_empty() {
        return None;
    }
    let plural = if names.len() == 1 { "" } else { "s" };
    let reason = format!(
        "it is out of date: the claim{plural} {} changed in {} since it was rendered",
        names.join(", "),
        suite.display()
    );
    Some(OutOfDate { suite: suite.clone(), reason, fix: again(report, suite) })
}

/// The command that renders a page again.
fn again(report: &Sidecar, suite: &Path) -> String {
    let command = report.command.replacen("specforge run ", "specforge report ", 1);
    let command = if command.is_empty() { format!("specforge report {}", suite.display()) } else { command };
    format!("render it again: `{command}`, after `specforge run` where runs are missing")
}
