//! `specforge plan FILE`: the dataflow graph with cache states and reasons.

use std::path::PathBuf;

use crate::cli::study::{self, Source};
use crate::cli::{Exit, Format, Global, output, overwrite, power};
use crate::exec::forecast;
use crate::exec::journal::Past;
use crate::plan::{is_saved, render, summary, why};
use crate::safe_fs;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(flatten)]
    source: Source,
    /// Also writes the whole plan, for `specforge stage` and for running it elsewhere
    #[arg(long, value_name = "PLAN.json")]
    save: Option<PathBuf>,
    /// Lists every stage of a suite, not only how many there are
    #[arg(long)]
    all: bool,
    /// Says only what the tests of a suite's claims can decide, and how many seeds settle those that are open
    #[arg(long)]
    power: bool,
}

/// Prints the plan.
pub fn run(options: &Options, global: &Global) -> Exit {
    let study = match study::read(&options.source, global) {
        Ok(study) => study,
        Err(exit) => return exit,
    };
    if let Some(path) = &options.save {
        let advice = "name another file, or remove this one first";
        if let Err(exit) = overwrite::allowed(path, "a saved plan", is_saved, advice, global) {
            return exit;
        }
        let text = serde_json::to_string(&study.plan).expect("a plan is plain data");
        if let Err(error) = safe_fs::replace(path, text.as_bytes()) {
            let message = format!("the plan cannot be written: {}: {error}", path.display());
            output::complain(global, &message, Some("name a file in a folder that you may write to"));
            return Exit::StageFailed;
        }
    }
    if options.power {
        return power::run(&study, global);
    }
    // The report stage must be the one that `run` would make.
    let reports = study.reports();
    let study = match study::settled(study, &reports, global) {
        Ok(settled) => settled.study,
        Err(exit) => return exit,
    };
    let plan = &study.plan;
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    let statuses = why::statuses(plan, &Past::of(&store, plan));
    let expected = forecast::expected(&store, plan, &statuses);
    let summarised = plan.suite.as_ref().filter(|_| !options.all);
    match (global.format, summarised) {
        (Format::Json, _) => output::json(&render::json(plan, &statuses, &expected)),
        (Format::Dot, None) => output::data(&render::dot(plan, &statuses)),
        (Format::Dot, Some(_)) => output::data(&summary::dot(plan, &statuses)),
        (Format::Mermaid, None) => output::data(&render::mermaid(plan, &statuses)),
        (Format::Mermaid, Some(_)) => output::data(&summary::mermaid(plan, &statuses)),
        (_, None) => output::data(&render::text(plan, &statuses, &expected)),
        (_, Some(suite)) => {
            let claims = power::table(plan);
            let claims = if claims.is_empty() { claims } else { format!("\n{claims}") };
            output::data(&format!("{}{claims}", summary::text(plan, suite, &statuses, &expected)));
        }
    }
    Exit::Ok
}
