//! `specforge cache export` and `specforge cache import`: records of runs that outlive their store.

use std::fs;
use std::path::PathBuf;

use serde_json::json;

use super::source::{self, Source};
use super::{Exit, Format, Global, output, run};
use crate::exec::records::{self, RecordError};
use crate::exec::{Store, StoreError};

/// Arguments of `cache export`.
#[derive(Debug, clap::Args)]
pub struct Export {
    #[command(flatten)]
    source: Source,
    /// The folder of the records
    #[arg(long, value_name = "DIR")]
    to: PathBuf,
    /// Also writes the weights of the trainings, for evaluations to come
    #[arg(long)]
    weights: bool,
}

/// Arguments of `cache import`.
#[derive(Debug, clap::Args)]
pub struct Import {
    /// The folder of the records
    #[arg(value_name = "DIR")]
    from: PathBuf,
}

/// Writes the records.
pub fn export(options: &Export, global: &Global) -> Exit {
    let comparison = match source::read(&options.source, global) {
        Ok(comparison) => comparison,
        Err(exit) => return exit,
    };
    let store = match comparison.store(global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    if let Err(error) = fs::create_dir_all(&options.to) {
        return run::complain(global, &StoreError::writing(&options.to, error));
    }
    match records::save(&comparison.plan, &store, &comparison.name, &options.to, options.weights) {
        Err(error) => complain(global, &error),
        Ok(saved) => {
            if global.format == Format::Json {
                output::json(&json!({
                    "written": saved.written, "present": saved.present, "unfinished": saved.unfinished,
                }));
            } else {
                let lines: String = saved.written.iter().map(|path| format!("{}\n", path.display())).collect();
                output::data_if_any(&lines);
                let (written, present, unfinished) = (saved.written.len(), saved.present, saved.unfinished);
                let text =
                    format!("{written} records written, {present} were there, {unfinished} runs are not finished");
                output::note(global, &text);
            }
            Exit::Ok
        }
    }
}

/// Restores the runs of the records.
pub fn import(options: &Import, store: &Store, global: &Global) -> Exit {
    match records::restore(store, &options.from) {
        Err(error) => complain(global, &error),
        Ok(restored) => {
            let records::Restored { records, stages, present } = restored;
            if global.format == Format::Json {
                output::json(&json!({ "records": records, "stages": stages, "present": present }));
            } else {
                let text = format!("{records} records: {stages} stages restored, {present} were in the store");
                output::note(global, &text);
            }
            Exit::Ok
        }
    }
}

fn complain(global: &Global, error: &RecordError) -> Exit {
    match error {
        RecordError::Store(error) => run::complain(global, error),
        RecordError::Record { .. } => {
            let advice = "records are written by `specforge cache export`; restore the file, or remove it";
            output::complain(global, &error.to_string(), Some(advice));
            Exit::StageFailed
        }
    }
}
