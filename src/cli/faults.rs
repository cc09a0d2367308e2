//! Errors of the store and of stages, as messages and exit codes.

use super::{Exit, Global, interruption, output};
use crate::exec::{StoreError, WorkError};
use crate::plan::{Plan, Stage};
use crate::study::publication::Unready;

/// Reports what a stage needs that is not available.
pub fn incapable(plan: &Plan, stage: &Stage, error: &WorkError, global: &Global) -> Exit {
    let (code, help) = error.advice();
    output::fault(global, code, &format!("{}: {error}", plan.label(stage)), help.as_deref());
    Exit::StageFailed
}

/// Reports an error of the store.
pub fn store(global: &Global, error: &StoreError) -> Exit {
    if matches!(error, StoreError::Interrupted) {
        return interruption::tell(global);
    }
    output::fault(global, error.code(), &error.to_string(), error.help());
    Exit::StageFailed
}

/// Reports why a report is not published.
pub fn unready(error: &Unready, global: &Global) -> Exit {
    match error {
        Unready::Store(error) => store(global, error),
        Unready::Plan(error) => {
            output::complain(global, &error.to_string(), None);
            Exit::Internal
        }
        Unready::Interrupted => Exit::Interrupted,
        Unready::Failed => Exit::StageFailed,
    }
}
