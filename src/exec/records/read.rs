//! Reads the record of a run and compares it with its digest and its file name.

use std::path::Path;

use super::{FORMAT, RunRecord, UNSEALED, names};
use crate::bounded;
use crate::seal::unsealed::Unsealed;
use crate::seal::{self, Seal};

/// Reads an unchanged record; fails with what is wrong with it.
pub(super) fn read(path: &Path, unsealed: &Unsealed) -> Result<RunRecord, String> {
    let text = bounded::text(path, bounded::RECORD).map_err(|error| error.to_string())?;
    let record: RunRecord =
        serde_json::from_str(&text).map_err(|error| format!("it is not the record of a run: {error}"))?;
    if ![UNSEALED, FORMAT].contains(&record.format) {
        return Err(format!("its format is {}, this version reads {FORMAT}", record.format));
    }
    match seal::state(&text, unsealed) {
        Seal::Whole | Seal::Earlier(_) => names::flaw(&record, path).map_or(Ok(record), Err),
        Seal::Broken => {
            Err("it was changed after it was written: it does not have its own digest".to_owned())
        }
        Seal::Absent => Err(seal::REMOVED.to_owned()),
    }
}
