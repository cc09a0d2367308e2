//! `specforge report FILE...`: renders a report again from the store; `--index` writes the overview of all
//! reports, `--check` finds edited pages. Never simulates: what follows from the spec alone (the robot, the
//! reference motion) is made if it is missing, as in a store filled from records.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::cli::specs::Variant;
use crate::cli::study::{self, Source};
use crate::cli::{Exit, Format, Global, faults, index, output, pages, progress};
use crate::exec::journal::Past;
use crate::exec::{self, Interrupt, Store, Workshop};
use crate::plan::why::{self, State};
use crate::plan::{Fingerprint, Stage, StageKind};
use crate::report::sidecar::{Sidecar, is_result};
use crate::study::page_name::{Destination, Settled};
use crate::study::works::works;
use crate::study::{Study, page, publication};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Specs to render the report of, or one plan that `plan --save` wrote; with --index the suites to list
    #[arg(value_name = "FILE", required_unless_present_any = ["index", "check"])]
    files: Vec<PathBuf>,
    #[command(flatten)]
    variant: Variant,
    /// Folder of the report [default: `reports/`, with the subfolders of the spec in `specs/`]
    #[arg(long, value_name = "DIR")]
    reports: Option<PathBuf>,
    /// Writes README.md instead: every claim of every suite below specs and what became of it
    #[arg(long, conflicts_with_all = ["profile", "sets", "deny"])]
    index: bool,
    /// Says which pages and figures were changed after they were rendered, by the digests in their records
    #[arg(long, conflicts_with_all = ["files", "index", "profile", "sets", "deny"])]
    check: bool,
}

/// Maximum number of stages that the message about missing results names.
const SHOWN: usize = 3;

/// Renders and publishes the report.
pub fn run(options: &Options, global: &Global) -> Exit {
    if options.index || options.check {
        let folder = options.reports.clone().unwrap_or_else(|| PathBuf::from("reports"));
        return if options.check {
            pages::check(&folder, global)
        } else {
            index::run(&options.files, &folder, global)
        };
    }
    let source = Source { files: options.files.clone(), variant: options.variant.clone() };
    let (Settled { study, own, note }, folder) =
        match study::named(&source, options.reports.as_deref(), global) {
            Ok(named) => named,
            Err(exit) => return exit,
        };
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    let statuses = why::statuses(&study.plan, &Past::of(&store, &study.plan));
    let absent: BTreeSet<&Fingerprint> =
        statuses.iter().filter(|(_, status)| status.state != State::Cached).map(|(key, _)| key).collect();
    // A stored report has all results, whatever happened to those since.
    let is_rendered = report_of(&study).is_some_and(|report| !absent.contains(&report.fingerprint));
    let derived = if is_rendered { BTreeSet::new() } else { derived(&study, &absent) };
    let absent = absent.into_iter().filter(|key| !is_rendered && !derived.contains(*key)).collect();
    if let Err(exit) = protect(&study, &absent, &folder, global) {
        return exit;
    }
    output::note(global, &note.unwrap_or_default());
    let rendering =
        Rendering { study: &study, derived, destination: Destination { folder: &folder, own: &own } };
    if store.is_writable() {
        return rendering.execute(&store, global);
    }
    // Rendering only reads the results, so a store that cannot be written is enough.
    match tempfile::tempdir() {
        Ok(beside) => rendering.execute(&Store::over(&store, beside.path()), global),
        Err(error) => {
            let path = std::env::temp_dir();
            let message = format!("the report cannot be rendered: {}: {error}", path.display());
            output::complain(global, &message, Some("make the store or the folder `TMPDIR` writable"));
            Exit::StageFailed
        }
    }
}

/// The stage that renders the report.
fn report_of(study: &Study) -> Option<&Stage> {
    study.plan.stages().find(|stage| stage.kind == StageKind::Report)
}

/// The stages that are missing although they follow from the spec alone, for the arms with a result.
fn derived(study: &Study, absent: &BTreeSet<&Fingerprint>) -> BTreeSet<Fingerprint> {
    let there = study.plan.stages().filter(|stage| !absent.contains(&stage.fingerprint));
    let users = there.flat_map(|stage| &stage.users).filter(|user| is_result(&user.stage));
    let arms: BTreeSet<&str> = users.map(|user| user.arm.as_str()).collect();
    let is_derived = |stage: &&Stage| {
        let is_used = || stage.users.iter().any(|user| arms.contains(user.arm.as_str()));
        stage.kind.is_of_spec_alone() && absent.contains(&stage.fingerprint) && is_used()
    };
    study.plan.stages().filter(is_derived).map(|stage| stage.fingerprint.clone()).collect()
}

/// Refuses an incomplete report without results, or with fewer than the page that it would replace. Reports
/// the error; `Err` is the exit code.
fn protect(
    study: &Study,
    absent: &BTreeSet<&Fingerprint>,
    folder: &Path,
    global: &Global,
) -> Result<(), Exit> {
    let missing = missing(study, absent);
    if missing.is_empty() {
        return Ok(());
    }
    let Some((message, advice)) = refusal(study, absent, &Sidecar::path(folder, &study.name)) else {
        return Ok(());
    };
    output::complain(global, &format!("{message}: {}", not_in_the_store(study, &missing)), Some(&advice));
    Err(Exit::StageFailed)
}

/// `3 of 12 stages are not in the store: robot, env and 1 more; ...`
fn not_in_the_store(study: &Study, missing: &[String]) -> String {
    let all = study.plan.stages().filter(|stage| stage.kind != StageKind::Report).count();
    let verb = if missing.len() == 1 { "is" } else { "are" };
    format!("{} of {all} stages {verb} not in the store, or damaged: {}", missing.len(), some(missing))
}

/// The stages whose results will be missing from the report.
fn missing(study: &Study, absent: &BTreeSet<&Fingerprint>) -> Vec<String> {
    let plan = &study.plan;
    let lacking =
        plan.stages().filter(|stage| stage.kind != StageKind::Report && absent.contains(&stage.fingerprint));
    lacking.map(|stage| plan.label(stage)).collect()
}

/// The first few of many stages.
fn some(stages: &[String]) -> String {
    let shown = stages.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    match stages.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more; `specforge plan` counts them"),
    }
}

/// Why an incomplete report is not written, and the fix: nothing has been learned or measured yet, or the
/// existing page has more results.
fn refusal(study: &Study, absent: &BTreeSet<&Fingerprint>, record: &Path) -> Option<(String, String)> {
    let there = study.plan.stages().filter(|stage| !absent.contains(&stage.fingerprint));
    let there = there.filter(|stage| stage.kind != StageKind::Report).flat_map(|stage| &stage.users);
    let results = there.filter(|user| is_result(&user.stage)).count();
    let again =
        "`specforge run` the same files first, or give the `--profile` and `--set` that they were run with";
    if results == 0 {
        return Some(("no result of this run is in the store".to_owned(), again.to_owned()));
    }
    page::objection(record, results, again)
}

/// A report to render.
struct Rendering<'a> {
    study: &'a Study,
    /// The missing stages that are made for it.
    derived: BTreeSet<Fingerprint>,
    destination: Destination<'a>,
}

impl Rendering<'_> {
    /// Renders and publishes the report. Fails after that if results are missing from it.
    fn execute(self, store: &Store, global: &Global) -> Exit {
        let Self { study, derived, destination } = self;
        let (works, interrupt) = (works(study), Interrupt::default());
        let events = progress::events(global);
        let plan = &study.plan;
        let selected = plan.stages().filter(|stage| stage.kind == StageKind::Report);
        let selected: BTreeSet<_> = selected.map(|stage| stage.fingerprint.clone()).chain(derived).collect();
        let settings =
            exec::Options { jobs: 1, keep_going: true, selected, reasons: Default::default(), single: None };
        let workshop =
            Workshop { plan, store, works: &works, events: events.as_ref(), interrupt: &interrupt };
        let outcome = match exec::run(&workshop, &settings) {
            Ok(outcome) => outcome,
            Err(error) => return faults::store(global, &error),
        };
        let Some(artefact) = outcome.report.as_ref().filter(|_| outcome.failures.is_empty()) else {
            return Exit::StageFailed;
        };
        // Damage in large files is found only when they are read.
        let there: BTreeSet<&Fingerprint> = outcome.worked.iter().chain(&outcome.cached).collect();
        let is_whole = report_of(study).is_some_and(|report| artefact.ends_with(report.fingerprint.as_str()));
        let keys = plan.stages().map(|stage| &stage.fingerprint);
        let absent: BTreeSet<&Fingerprint> = keys.filter(|key| !is_whole && !there.contains(key)).collect();
        if let Err(exit) = protect(study, &absent, destination.folder, global) {
            return exit;
        }
        let tell = |text: &str| output::note(global, text);
        let ready = match publication::ready(artefact, study, destination, &workshop, &tell) {
            Ok(ready) => ready,
            Err(error) => return faults::unready(&error, global),
        };
        let path = match ready.publish(&|text| tell(&format!("warning: {text}"))) {
            Ok(path) => path,
            Err(error) => return faults::store(global, &error),
        };
        let missing = missing(study, &absent);
        if global.format == Format::Json {
            let answer = serde_json::json!({ "report": path.display().to_string(), "missing": missing });
            output::data(&answer.to_string());
        } else {
            output::data(&path.display().to_string());
            if !missing.is_empty() {
                let lacking = not_in_the_store(study, &missing);
                let message = format!("results are missing from the report: {lacking}");
                output::complain(global, &message, Some("`specforge run` the same files to make them"));
            }
        }
        if missing.is_empty() { Exit::Ok } else { Exit::StageFailed }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser as _;

    use super::*;
    use crate::cli::{Arguments, Command};
    use crate::report::model::StageRecord;
    use crate::report::sidecar::ArmRecord;

    fn record(folder: &Path, stages: &[&str]) -> PathBuf {
        let stages =
            stages.iter().map(|stage| StageRecord { stage: (*stage).into(), ..StageRecord::default() });
        let arms = vec![ArmRecord { stages: stages.collect(), ..ArmRecord::default() }];
        let path = folder.join("page.json");
        let text =
            serde_json::to_string(&Sidecar { arms, ..Sidecar::default() }).expect("a record is plain data");
        std::fs::write(&path, text).expect("it can be written");
        path
    }

    #[test]
    fn a_page_that_knows_more_is_kept_and_one_that_knows_less_is_not() {
        let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/specs/tocabi_squat_torque.toml");
        let arguments = Arguments::try_parse_from(["specforge", "report", spec]).expect("arguments");
        let Command::Report(options) = &arguments.command else { unreachable!("it is a report") };
        let source = Source { files: options.files.clone(), variant: options.variant.clone() };
        let Ok(study) = study::read(&source, &arguments.global) else { panic!("the spec has a plan") };
        let folder = tempfile::tempdir().expect("a folder");
        let without = |kinds: &[StageKind]| {
            let absent = study.plan.stages().filter(|stage| kinds.contains(&stage.kind));
            absent.map(|stage| &stage.fingerprint).collect::<BTreeSet<_>>()
        };
        let interrupted = without(&[StageKind::Evaluate, StageKind::Export, StageKind::Transfer]);
        let none = folder.path().join("none.json");
        assert_eq!(refusal(&study, &interrupted, &none), None, "a report of what there is");
        let begun = record(folder.path(), &["robot", "env", "learner"]);
        assert_eq!(refusal(&study, &interrupted, &begun), None);
        let complete = record(
            folder.path(),
            &["robot", "learner", "evaluate.nominal", "deploy.policy", "deploy.mujoco"],
        );
        let (message, _) = refusal(&study, &interrupted, &complete).expect("a refusal");
        assert!(message.contains("page.md has 4 results, and this report would have"), "{message}");
        std::fs::write(&complete, "{").expect("it can be written");
        let (message, advice) =
            refusal(&study, &interrupted, &complete).expect("nobody knows what the page has");
        assert!(message.contains("page.json is not a report's record"), "{message}");
        assert!(advice.contains("delete it and its page"), "{advice}");
        let nothing = &interrupted | &without(&[StageKind::Learner, StageKind::FineTune]);
        assert!(refusal(&study, &nothing, &none).is_some(), "no result at all");
    }
}
