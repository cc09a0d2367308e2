//! `specforge report FILE...`: renders a report again from what is in the store; `--index` writes the page of all reports.
//! Never simulates.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::comparison::Comparison;
use super::source::{self, Source};
use super::specs::Variant;
use super::{Exit, Format, Global, index, output, run, works};
use crate::exec::journal::Past;
use crate::exec::{self, Interrupt, Workshop};
use crate::plan::why::{self, State};
use crate::plan::{Fingerprint, StageKind};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Specs to render the report of, or one plan that `plan --save` wrote; with --index the suites to list
    #[arg(value_name = "FILE", required_unless_present = "index")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    variant: Variant,
    /// Where the report is written [default: reports beside the store]
    #[arg(long, value_name = "DIR")]
    reports: Option<PathBuf>,
    /// Writes README.md instead: every claim of every suite in specs/suites and what became of it
    #[arg(long, conflicts_with_all = ["profile", "sets", "deny"])]
    index: bool,
}

/// Stages that the warning of missing results names.
const SHOWN: usize = 3;

/// Renders and publishes the report.
pub fn run(options: &Options, global: &Global) -> Exit {
    if options.index {
        let folder = options.reports.clone().unwrap_or_else(|| PathBuf::from("reports"));
        return index::run(&options.files, &folder, global);
    }
    let source = Source { files: options.files.clone(), variant: options.variant.clone() };
    let comparison = match source::read(&source, global) {
        Ok(comparison) => comparison,
        Err(exit) => return exit,
    };
    let store = comparison.store(global);
    let statuses = why::statuses(&comparison.plan, &Past::of(&store));
    let absent: BTreeSet<&Fingerprint> =
        statuses.iter().filter(|(_, status)| status.state != State::Cached).map(|(key, _)| key).collect();
    let missing = missing(&comparison, &absent);
    let all = comparison.plan.stages().filter(|stage| stage.kind != StageKind::Report).count();
    if missing.len() == all {
        let advice = "`specforge run` the same files, with the same profile, first";
        output::complain(global, "nothing of this run is in the store", Some(advice));
        return Exit::StageFailed;
    }
    if !missing.is_empty() {
        let shown = missing.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = match missing.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more; `specforge plan` counts them"),
        };
        let (lacking, absent) = (missing.len(), "not in the store, and so not in the report");
        output::note(global, &format!("warning: {lacking} of {all} stages are {absent}: {shown}{more}"));
    }
    execute(&comparison, options, global)
}

/// The stages whose results the report will lack.
fn missing(comparison: &Comparison, absent: &BTreeSet<&Fingerprint>) -> Vec<String> {
    let plan = &comparison.plan;
    let lacking = plan.stages().filter(|stage| stage.kind != StageKind::Report && absent.contains(&stage.fingerprint));
    lacking.map(|stage| plan.label(stage)).collect()
}

fn execute(comparison: &Comparison, options: &Options, global: &Global) -> Exit {
    let (store, works, interrupt) = (comparison.store(global), works::works(comparison), Interrupt::default());
    let events = run::audience(global);
    let plan = &comparison.plan;
    let selected = plan.stages().filter(|stage| stage.kind == StageKind::Report);
    let selected: BTreeSet<_> = selected.map(|stage| stage.fingerprint.clone()).collect();
    let settings = exec::Options { jobs: 1, keep_going: true, selected, reasons: Default::default() };
    let workshop = Workshop { plan, store: &store, works: &works, events: events.as_ref(), interrupt: &interrupt };
    let outcome = match exec::run(&workshop, &settings) {
        Ok(outcome) => outcome,
        Err(error) => return run::complain(global, &error),
    };
    let folder = options.reports.clone().unwrap_or_else(|| comparison.project.join("reports"));
    let Some(artefact) = outcome.report.filter(|_| outcome.failures.is_empty()) else { return Exit::StageFailed };
    match exec::publish::publish(&artefact, &folder, &comparison.name) {
        Err(error) => run::complain(global, &error),
        Ok(path) => {
            if global.format == Format::Json {
                output::data(&serde_json::json!({ "report": path.display().to_string() }).to_string());
            } else {
                output::data(&path.display().to_string());
            }
            Exit::Ok
        }
    }
}
