//! `specforge run FILE...`: checks, plans, executes and publishes the report.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::cli::study::{self, Source};
use crate::cli::{Exit, Format, Global, faults, interruption, next, output, progress};
use crate::escape::terminal::{self, one_line};
use crate::exec::events::Event;
use crate::exec::journal::Past;
use crate::exec::{self, Interrupt, Outcome, Store, StoreError, Workshop, capability, last_words};
use crate::kinds::learn::{Learner, Ppo};
use crate::plan::why::{self, State};
use crate::plan::{Fingerprint, Selection, Stage, StageKind, render};
use crate::quantity::span;
use crate::report::claim::{self, Judged, Ruling};
use crate::report::sidecar::Sidecar;
use crate::report::tasks::{self, TaskRecord};
use crate::spec::Section;
use crate::spec::typed::InSection;
use crate::study::page_name::{Destination, Settled};
use crate::study::publication::{self, Ready};
use crate::study::works::works;
use crate::study::{Study, page};

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(flatten)]
    pub(super) source: Source,
    /// Number of threads, and largest number of stages at once [default: the machine's cores]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Runs only this stage (`learner`, `ARM/learner`); may be repeated
    #[arg(long, value_name = "STAGE")]
    only: Vec<String>,
    /// Runs this stage and all that depend on it
    #[arg(long, value_name = "STAGE")]
    from: Vec<String>,
    /// Runs this stage and all that it needs
    #[arg(long, value_name = "STAGE")]
    until: Vec<String>,
    /// Continues with other stages after a failure; this is the default
    #[arg(long, conflicts_with = "fail_fast")]
    keep_going: bool,
    /// Starts no further stage after a failure
    #[arg(long)]
    fail_fast: bool,
    /// Prints what would run, and runs nothing
    #[arg(long)]
    dry_run: bool,
    /// Folder of the report [default: `reports/`, with the subfolders of the spec in `specs/`]
    #[arg(long, value_name = "DIR")]
    reports: Option<PathBuf>,
}

/// Runs the specs.
pub fn run(options: &Options, global: &Global) -> Exit {
    let start = Instant::now();
    let interrupt = match interruption::listen(global, || {}) {
        Ok(interrupt) => interrupt,
        Err(exit) => return exit,
    };
    let (Settled { study, own, note }, folder) =
        match study::named(&options.source, options.reports.as_deref(), global) {
            Ok(named) => named,
            Err(exit) => return exit,
        };
    let selection =
        Selection { only: options.only.clone(), from: options.from.clone(), until: options.until.clone() };
    let selected = match selection.apply(&study.plan) {
        Ok(selected) => selected,
        Err(error) => {
            output::complain(global, &error.to_string(), None);
            return Exit::Usage;
        }
    };
    let is_reported = study
        .plan
        .stages()
        .any(|stage| stage.kind == StageKind::Report && selected.contains(&stage.fingerprint));
    let note = note.filter(|_| is_reported).unwrap_or_default();
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    let statuses = why::statuses(&study.plan, &Past::of(&store, &study.plan));
    if options.dry_run {
        output::note(global, &note);
        return preview(&study, &selected, &statuses, global);
    }
    let is_open = |stage: &&Stage| {
        selected.contains(&stage.fingerprint) && statuses[&stage.fingerprint].state != State::Cached
    };
    for stage in study.plan.stages().filter(is_open) {
        if let Err(error) = capability::check(&study.plan, stage) {
            return faults::incapable(&study.plan, stage, &error, global);
        }
    }
    if study.plan.stages().filter(is_open).any(|stage| stage.kind == StageKind::Learner) {
        output::note(global, &long(&study));
    }
    output::note(global, &note);
    let jobs = options.jobs.map_or_else(cores, usize::from);
    let reasons = statuses.iter().map(|(key, status)| (key.clone(), render::reasons(status))).collect();
    let settings = exec::Options { jobs, keep_going: !options.fail_fast, selected, reasons, single: None };
    let destination = Destination { folder: &folder, own: &own };
    let task = Task { study: &study, store: &store, settings: &settings, destination, start };
    execute(&task, &interrupt, global)
}

/// Number of samples above which a training takes hours on a desktop.
const MANY: u64 = 20_000_000;

/// Warns that a training without a profile is long and names shorter profiles; empty if not applicable.
fn long(study: &Study) -> String {
    let arms = study.plan.arms.iter().filter(|arm| arm.request.profile.is_none());
    let samples =
        arms.filter_map(|arm| Section::new(&arm.fields.only(&[Learner::SECTION])).at(Ppo::samples)).max();
    let shorter =
        ["quick", "desk"].into_iter().filter(|name| study.profiles.iter().any(|known| known == name));
    let shorter: Vec<String> = shorter.map(|name| format!("`--profile {name}`")).collect();
    match samples.filter(|samples| *samples >= MANY && !shorter.is_empty()) {
        Some(samples) => {
            let (millions, verb) = (samples as f64 / 1e6, if shorter.len() == 1 { "is" } else { "are" });
            format!("this trains {millions} M samples, for hours; {} {verb} shorter", shorter.join(" and "))
        }
        None => String::new(),
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// `--dry-run`: prints the stages that would run, with their reasons.
fn preview(
    study: &Study,
    selected: &std::collections::BTreeSet<Fingerprint>,
    statuses: &render::Statuses,
    global: &Global,
) -> Exit {
    let plan = &study.plan;
    let open = |key: &Fingerprint| statuses[key].state != State::Cached && selected.contains(key);
    let stages: Vec<_> = plan.stages().filter(|stage| open(&stage.fingerprint)).collect();
    if global.format == Format::Json {
        let list = stages.iter().map(|stage| {
            serde_json::json!({ "key": stage.fingerprint, "name": plan.label(stage),
                    "reason": statuses[&stage.fingerprint] })
        });
        output::json(&serde_json::json!({ "stages": list.collect::<Vec<_>>() }));
        return Exit::Ok;
    }
    let mut text = one_line(&format!("{} of {} stages would run", stages.len(), plan.stages().len()));
    if plan.suite.is_some() && global.verbose == 0 {
        let mut counts: BTreeMap<(StageKind, &str), usize> = BTreeMap::new();
        stages.iter().for_each(|stage| *counts.entry((stage.kind, stage.name())).or_default() += 1);
        counts.iter().for_each(|((_, name), count)| text += &one_line(&format!("  {count:>6} x {name}")));
        output::data(&text);
        output::note(global, "`--verbose` lists them");
        return Exit::Ok;
    }
    for stage in stages {
        let reasons = match render::reasons(&statuses[&stage.fingerprint]) {
            none if none.is_empty() => "not in the store".to_owned(),
            reasons => reasons.join("; "),
        };
        text += &one_line(&format!("  {:<32} {reasons}", plan.label(stage)));
    }
    output::data(&text);
    Exit::Ok
}

/// What to execute.
struct Task<'a> {
    study: &'a Study,
    store: &'a Store,
    settings: &'a exec::Options,
    destination: Destination<'a>,
    /// When the command started.
    start: Instant,
}

fn execute(task: &Task, interrupt: &Interrupt, global: &Global) -> Exit {
    let Task { study, store, settings, destination, start } = *task;
    interrupt.work();
    let (events, works) = (progress::events(global), works(study));
    if let Err(error) = last_words::listen(Some(store.root().to_owned()), events.clone(), interrupt) {
        output::complain(global, &format!("cannot prepare for crashes: {error}"), None);
        return Exit::Internal;
    }
    let workshop = Workshop { plan: &study.plan, store, works: &works, events: events.as_ref(), interrupt };
    let outcome = match exec::run(&workshop, settings) {
        Ok(outcome) => outcome,
        Err(error) => return faults::store(global, &error),
    };
    let (published, record) = match publish(&outcome, study, destination, &workshop, global) {
        Ok(published) => published,
        Err(exit) => return exit,
    };
    let wall_s = start.elapsed().as_secs_f64();
    events.emit(Event::RunFinished {
        outcome: verdict(&outcome).into(),
        report: published.page().map(|path| path.display().to_string()),
        worked: outcome.worked.len(),
        cached: outcome.cached.len(),
        failed: outcome.failures.len() + outcome.skipped.len(),
        failing_arms: tasks::failing(&record.tasks).map(TaskRecord::brief).collect(),
        unjudged_arms: tasks::unjudged(&record.tasks).map(TaskRecord::unjudged_brief).collect(),
        claims: record.claims.iter().map(Judged::brief).collect(),
        wall_s,
    });
    summarise(&outcome, study, wall_s, global);
    tell_tasks(&record.tasks, global);
    tell_claims(&record.claims, global);
    tell_page(&published, global);
    next::tell(&study.plan, store, published.page().map(|page| (page, &record)), global);
    match verdict(&outcome) {
        "interrupted" => Exit::Interrupted,
        "failed" => Exit::StageFailed,
        _ if matches!(published, Published::Kept(..)) => Exit::StageFailed,
        _ if counts(study) && record.claims.iter().any(|claim| claim.verdict == Ruling::Fail) => {
            Exit::ClaimFailed
        }
        _ => Exit::Ok,
    }
}

/// The result of publishing the report.
enum Published {
    /// The run made no report.
    Nothing,
    /// The report was written to this page.
    Page(PathBuf),
    /// The existing page was kept: why, and the fix.
    Kept(String, String),
}

impl Published {
    /// The page that was written, if any.
    fn page(&self) -> Option<&Path> {
        match self {
            Self::Page(path) => Some(path),
            Self::Nothing | Self::Kept(..) => None,
        }
    }
}

/// Publishes the report, unless it is incomplete and the existing page has more results. Returns the report's
/// record as well. Reports errors; `Err` is the exit code.
fn publish(
    outcome: &Outcome,
    study: &Study,
    destination: Destination,
    workshop: &Workshop,
    global: &Global,
) -> Result<(Published, Sidecar), Exit> {
    let Some(artefact) = &outcome.report else { return Ok((Published::Nothing, Sidecar::default())) };
    let ready =
        publication::ready(artefact, study, destination, workshop, &|text| output::note(global, text))
            .map_err(|error| faults::unready(&error, global))?;
    let Ready { name, artefact, .. } = &ready;
    let record = Sidecar::read(&Sidecar::path(artefact, name)).map_err(|error| {
        faults::store(global, &StoreError::Damaged { path: artefact.clone(), reason: error.to_string() })
    })?;
    let is_whole = outcome.worked.len() + outcome.cached.len() == study.plan.stages().len();
    let again = "mend the cause and run all stages again";
    let objection = || page::objection(&Sidecar::path(destination.folder, name), record.results(), again);
    let published = match (!is_whole).then(objection).flatten() {
        Some((reason, advice)) => Published::Kept(reason, advice),
        None => {
            let page = ready.publish(&|text| output::note(global, &format!("warning: {text}")));
            Published::Page(page.map_err(|error| faults::store(global, &error))?)
        }
    };
    Ok((published, record))
}

/// Prints the page that was written, or why it was not.
fn tell_page(published: &Published, global: &Global) {
    match published {
        Published::Page(path) if global.format != Format::Json => output::data(&path.display().to_string()),
        Published::Kept(reason, advice) => {
            output::complain(global, &format!("{reason}: the page is kept"), Some(advice));
        }
        Published::Page(_) | Published::Nothing => {}
    }
}

/// Whether a failed claim makes the run fail.
fn counts(study: &Study) -> bool {
    study.plan.suite.as_ref().is_some_and(|suite| suite.claims_count)
}

/// Prints the arms that fail their task, one line each, before any claims.
fn tell_tasks(records: &[TaskRecord], global: &Global) {
    if global.format != Format::Json {
        tasks::failing(records)
            .for_each(|record| output::note(global, &format!("task failed: {}", record.sentence())));
        for record in tasks::unjudged(records) {
            output::note(global, &format!("task not judged: {}", record.unjudged_sentence()));
        }
    }
}

/// Prints the claims, one line each.
fn tell_claims(judged: &[Judged], global: &Global) {
    if global.format != Format::Json {
        claim::meaningless(judged)
            .iter()
            .for_each(|told| output::note(global, &terminal::line(&told.replace("**", ""))));
        judged.iter().for_each(|claim| {
            output::note(global, &terminal::line(&format!("{}: {}", claim.id, claim.verdict.word())))
        });
    }
}

fn verdict(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome { interrupted: true, .. } => "interrupted",
        Outcome { failures, .. } if !failures.is_empty() => "failed",
        _ => "ok",
    }
}

/// Prints the last line on standard error.
fn summarise(outcome: &Outcome, study: &Study, wall_s: f64, global: &Global) {
    if global.format == Format::Json {
        return;
    }
    let counts = BTreeMap::from([
        (0, (outcome.worked.len(), "done")),
        (1, (outcome.cached.len(), "cached")),
        (2, (outcome.failures.len(), "failed")),
        (3, (outcome.skipped.len(), "could not start")),
    ]);
    let counts =
        counts.values().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}"));
    let counts = counts.collect::<Vec<_>>().join(", ");
    output::note(global, &format!("{}: {counts}, in {}", study.name, span(wall_s)));
    if outcome.interrupted {
        output::note(global, "interrupted; run the same command again to resume from the checkpoints");
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::cli::{Arguments, Command};

    fn told(more: &[&str]) -> String {
        let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/specs/tocabi_squat_torque.toml");
        let arguments =
            Arguments::try_parse_from([&["specforge", "run", spec], more].concat()).expect("arguments");
        let Command::Run(options) = &arguments.command else { unreachable!("it is a run") };
        let Ok(study) = study::read(&options.source, &arguments.global) else {
            panic!("the spec has a plan")
        };
        long(&study)
    }

    #[test]
    fn a_long_training_is_told_with_the_profiles_that_are_shorter() {
        let expected =
            "this trains 80 M samples, for hours; `--profile quick` and `--profile desk` are shorter";
        assert_eq!(told(&[]), expected);
        assert_eq!(told(&["--profile", "quick"]), "");
        assert_eq!(told(&["--set", "learn.samples=19 M"]), "");
    }
}
