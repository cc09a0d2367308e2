//! Shared by the commands that work on a plan: its files, its store, and the path of its page. Everything
//! here reports its errors.

use std::path::{Path, PathBuf};

use super::specs::{Variant, told};
use super::{Exit, Global, faults, output};
use crate::exec::Store;
use crate::study::page_name::{self, Settled};
use crate::study::{Study, saved};
use crate::{escape, safe_fs};

/// What a plan is made from.
#[derive(Clone, Debug, clap::Args)]
pub struct Source {
    /// Specs to run and compare, or one plan that `plan --save` wrote
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub variant: Variant,
}

/// Reads, checks and lowers the specs. Reports errors; `Err` is the exit code.
pub fn read(source: &Source, global: &Global) -> Result<Study, Exit> {
    told(|log| Study::read(&source.files, &source.variant.options(), log), global)
}

/// Reads a saved plan. Reports errors; `Err` is the exit code.
pub fn saved(plan: &Path, global: &Global) -> Result<Study, Exit> {
    told(|log| saved::read(plan, log), global)
}

/// The store named by the user, or the project's. Reports errors; `Err` is the exit code.
pub fn store(study: &Study, global: &Global) -> Result<Store, Exit> {
    study.store(global.store.clone()).map_err(|error| faults::store(global, &error))
}

/// Reads the specs and settles the name of their report in its folder, which is given, too. Reports errors;
/// `Err` is the exit code.
pub fn named(source: &Source, reports: Option<&Path>, global: &Global) -> Result<(Settled, PathBuf), Exit> {
    let study = read(source, global)?;
    let folder = folder(reports, &study, global)?;
    Ok((settled(study, &folder, global)?, folder))
}

/// The folder for the report: the one named by the user, or its own below the project's `reports`. If it
/// cannot be written, reports that before any work starts; `Err` is the exit code.
fn folder(chosen: Option<&Path>, study: &Study, global: &Global) -> Result<PathBuf, Exit> {
    let folder = chosen.map_or_else(|| study.reports(), Path::to_owned);
    let reason = if folder.exists() && !folder.is_dir() {
        "it is a file".to_owned()
    } else {
        match safe_fs::is_writable(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) => error.to_string(),
        }
    };
    let message = format!("reports cannot be written into {}: {reason}", escape::file(&folder));
    output::complain(global, &message, Some("name a folder that can be written with `--reports DIR`"));
    Err(Exit::Usage)
}

/// Settles the report's name, which depends on what the folder contains. Reports errors; `Err` is the exit
/// code.
pub fn settled(study: Study, folder: &Path, global: &Global) -> Result<Settled, Exit> {
    page_name::settled(study, folder).map_err(|error| {
        output::complain(global, &error.to_string(), None);
        Exit::Internal
    })
}
