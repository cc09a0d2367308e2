//! What the commands share that work on a plan: its files, its store, and where its page goes. All of it
//! prints what keeps the command from its work.

use std::path::{Path, PathBuf};

use super::specs::{Variant, told};
use super::{Exit, Global, faults, output};
use crate::exec::Store;
use crate::study::page_name::{self, Settled};
use crate::study::{Study, saved};

/// What a plan is made from.
#[derive(Clone, Debug, clap::Args)]
pub struct Source {
    /// Specs to run and compare, or one plan that `plan --save` wrote
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub variant: Variant,
}

/// Reads, checks and lowers. `Err` is the exit code; everything has been said then.
pub fn read(source: &Source, global: &Global) -> Result<Study, Exit> {
    told(|log| Study::read(&source.files, &source.variant.options(), log), global)
}

/// A plan that was saved. `Err` is the exit code; everything has been said then.
pub fn saved(plan: &Path, global: &Global) -> Result<Study, Exit> {
    told(|log| saved::read(plan, log), global)
}

/// The store that the user named, or the project's. `Err` is the exit code; everything has been said then.
pub fn store(study: &Study, global: &Global) -> Result<Store, Exit> {
    study.store(global.store.clone()).map_err(|error| faults::store(global, &error))
}

/// Where the report is written: into the folder that the user named, or into its own below the project's
/// `reports`. `Err` is the exit code when that is no folder; it has been said then, before anything is worked
/// on.
pub fn reports(chosen: Option<&Path>, study: &Study, global: &Global) -> Result<PathBuf, Exit> {
    let folder = chosen.map_or_else(|| study.reports(), Path::to_owned);
    if folder.exists() && !folder.is_dir() {
        let message = format!("reports cannot be written into {}, which is a file", folder.display());
        output::complain(global, &message, Some("name a folder: `--reports DIR`"));
        return Err(Exit::Usage);
    }
    Ok(folder)
}

/// The study with the name that its report can have in a folder as it is now. `Err` is the exit code;
/// everything has been said then.
pub fn settled(study: Study, folder: &Path, global: &Global) -> Result<Settled, Exit> {
    page_name::settled(study, folder).map_err(|error| {
        output::complain(global, &error.to_string(), None);
        Exit::Internal
    })
}
