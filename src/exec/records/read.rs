//! Reads the record of a run and compares it with its digest and its file name.

use std::path::Path;

use serde::Deserialize;

use super::{FORMAT, RunRecord, names};
use crate::bounded;
use crate::seal::{self, Seal};

/// The field that tells whether this version knows the others.
#[derive(Deserialize)]
struct Head {
    format: u32,
}

/// Reads an unchanged record; fails with what is wrong with it.
pub(super) fn read(path: &Path) -> Result<RunRecord, String> {
    let text = bounded::text(path, bounded::RECORD).map_err(|error| error.to_string())?;
    let foreign = |error: serde_json::Error| format!("it is not the record of a run: {error}");
    let Head { format } = serde_json::from_str(&text).map_err(foreign)?;
    if format != FORMAT {
        return Err(format!("its format is {format}, this version reads {FORMAT}"));
    }
    let record: RunRecord = serde_json::from_str(&text).map_err(foreign)?;
    match seal::state(&text) {
        Seal::Whole => names::flaw(&record, path).map_or(Ok(record), Err),
        Seal::Broken => {
            Err("it was changed after it was written: it does not have its own digest".to_owned())
        }
        Seal::Absent => Err(seal::REMOVED.to_owned()),
    }
}
