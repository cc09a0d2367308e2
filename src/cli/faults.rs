//! Faults of the store and of stages, as messages and exit codes.

use super::{Exit, Global, interruption, output};
use crate::exec::{StoreError, WorkError};
use crate::plan::{Plan, Stage};
use crate::study::publication::Unready;

/// Tells what a stage needs that is not there.
pub fn incapable(plan: &Plan, stage: &Stage, error: &WorkError, global: &Global) -> Exit {
    let (code, help) = error.advice();
    output::fault(global, code, &format!("{}: {error}", plan.label(stage)), help.as_deref());
    Exit::StageFailed
}

/// A fault of the store, told to the user.
pub fn store(global: &Global, error: &StoreError) -> Exit {
    if matches!(error, StoreError::Interrupted) {
        return interruption::tell(global);
    }
    output::fault(global, error.code(), &error.to_string(), error.help());
    Exit::StageFailed
}

/// Why a report is not published, told to the user.
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
