//! `specforge plan FILE`: the dataflow graph with cache states and reasons.

use std::path::PathBuf;

use super::comparison::{self, Source};
use super::{Exit, Format, Global, output};
use crate::exec::journal::Past;
use crate::plan::{render, why};

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(flatten)]
    source: Source,
    /// Also writes the whole plan, for `specforge stage` and for running it elsewhere
    #[arg(long, value_name = "PLAN.json")]
    save: Option<PathBuf>,
}

/// Prints the plan.
pub fn run(options: &Options, global: &Global) -> Exit {
    let comparison = match comparison::read(&options.source, global) {
        Ok(comparison) => comparison,
        Err(exit) => return exit,
    };
    let plan = &comparison.plan;
    if let Some(path) = &options.save {
        let text = serde_json::to_string(plan).expect("a plan is plain data");
        if let Err(error) = std::fs::write(path, text) {
            output::complain(global, &format!("{}: {error}", path.display()), None);
            return Exit::StageFailed;
        }
    }
    let store = comparison.store(global);
    let statuses = why::statuses(plan, &Past::of(&store));
    match global.format {
        Format::Json => output::json(&render::json(plan, &statuses)),
        Format::Dot => output::data(&render::dot(plan, &statuses)),
        Format::Mermaid => output::data(&render::mermaid(plan, &statuses)),
        _ => output::data(&render::text(plan, &statuses)),
    }
    Exit::Ok
}
