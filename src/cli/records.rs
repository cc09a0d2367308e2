//! `specforge cache export` and `specforge cache import`: records of runs that outlive their store.

use std::fs;
use std::path::PathBuf;

use serde_json::json;

use super::study::{self, Source};
use super::{Exit, Format, Global, faults, output};
use crate::exec::Store;
use crate::exec::lock::Wait;
use crate::exec::records::{self, RecordError};

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
    if options.to.exists() && !options.to.is_dir() {
        let message = format!("{} is a file, not a folder for records", options.to.display());
        output::complain(global, &message, Some("name a folder: `--to DIR`"));
        return Exit::Usage;
    }
    let study = match study::read(&options.source, global) {
        Ok(study) => study,
        Err(exit) => return exit,
    };
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    if let Err(source) = fs::create_dir_all(&options.to) {
        return complain(global, &RecordError::Unwritten { path: options.to.clone(), source });
    }
    match records::save(&study.plan, &store, &study.name, &options.to, options.weights) {
        Err(error) => complain(global, &error),
        Ok(saved) => {
            if global.format == Format::Json {
                output::json(&json!({
                    "written": saved.written, "present": saved.present, "unfinished": saved.unfinished,
                    "weightless": saved.weightless,
                }));
            } else {
                let lines: String =
                    saved.written.iter().map(|path| format!("{}\n", path.display())).collect();
                output::data_if_any(&lines);
                let text = format!(
                    "{} written, {} there already, {} not finished",
                    counted(saved.written.len(), "record"),
                    saved.present,
                    counted(saved.unfinished, "run")
                );
                output::note(global, &text);
                if saved.weightless > 0 {
                    let records = counted(saved.weightless, "record");
                    let message =
                        format!("{records} without weights: the trainings were restored without them");
                    output::note(global, &format!("{message}; run them again to have them"));
                }
            }
            Exit::Ok
        }
    }
}

/// Restores the runs of the records.
pub fn import(options: &Import, store: &Store, global: &Global) -> Exit {
    if options.from.exists() && !options.from.is_dir() {
        let message = format!("{} is a file, not a folder of records", options.from.display());
        output::complain(
            global,
            &message,
            Some("name the folder that `specforge cache export --to DIR` has written"),
        );
        return Exit::Usage;
    }
    let root = store.root().display();
    let tell = |who: &str| {
        output::note(global, &format!("{who} works on a stage in {root}; waiting for its result"))
    };
    match records::restore(store, &options.from, &Wait { tell: Some(&tell), ..Wait::default() }) {
        Err(error) => complain(global, &error),
        Ok(restored) => {
            let records::Restored { records, stages, present, foreign, refused } = restored;
            if global.format == Format::Json {
                let refused: Vec<String> = refused.iter().map(RecordError::to_string).collect();
                output::json(&json!({
                    "records": records, "stages": stages, "present": present, "skipped": foreign,
                    "refused": refused,
                }));
            } else {
                for path in &foreign {
                    let what = "is not the record of a run, and was skipped";
                    output::note(global, &format!("warning: {} {what}", path.display()));
                }
                for error in &refused {
                    let _ = complain(global, error);
                }
                let [records, stages] = [counted(records, "record"), counted(stages, "stage")];
                output::note(
                    global,
                    &format!("{records}: {stages} restored, {present} in the store already"),
                );
            }
            if refused.is_empty() { Exit::Ok } else { Exit::StageFailed }
        }
    }
}

/// `1 record`, `2 records`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn complain(global: &Global, error: &RecordError) -> Exit {
    let advice = match error {
        RecordError::Store(error) => return faults::store(global, error),
        RecordError::Folder { .. } | RecordError::Absent { .. } => {
            "name the folder that `specforge cache export --to DIR` has written"
        }
        RecordError::Unwritten { .. } => {
            "free some space, make the folder writable, or choose another one: `--to DIR`"
        }
        RecordError::Occupied { .. } => "name another folder: `--to DIR`, or move the file away",
        RecordError::Record { .. } => {
            "records are written by `specforge cache export`; restore the file, or remove it"
        }
    };
    output::complain(global, &error.to_string(), Some(advice));
    Exit::StageFailed
}
