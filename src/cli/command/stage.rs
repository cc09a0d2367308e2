//! `specforge stage FINGERPRINT --plan PLAN.json`: runs a single stage, the unit of distribution. Its inputs
//! must be in the store; a lock coordinates concurrent processes.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::cli::{Exit, Global, faults, interruption, output, progress, study};
use crate::exec::{self, Workshop, capability, last_words};
use crate::study::works::works;

/// Arguments of `stage`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The stage's key, at least six digits, or its name
    #[arg(value_name = "FINGERPRINT")]
    stage: String,
    /// The plan that `plan --save` wrote
    #[arg(long, value_name = "PLAN.json")]
    plan: PathBuf,
    /// Threads [default: the machine's cores]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
}

/// Runs the stage.
pub fn run(options: &Options, global: &Global) -> Exit {
    let interrupt = match interruption::listen(global, || {}) {
        Ok(interrupt) => interrupt,
        Err(exit) => return exit,
    };
    let study = match study::saved(&options.plan, global) {
        Ok(study) => study,
        Err(exit) => return exit,
    };
    let plan = &study.plan;
    let keys: BTreeSet<_> =
        plan.find(&options.stage).into_iter().map(|stage| stage.fingerprint.clone()).collect();
    if keys.len() != 1 {
        let found = if keys.is_empty() { "no stage" } else { "more than one stage" };
        let words = plan.words().into_iter().collect::<Vec<_>>().join(", ");
        let advice = format!("the stages are {words}; a key is unambiguous");
        output::complain(global, &format!("{found} is meant by `{}`", options.stage), Some(&advice));
        return Exit::Usage;
    }
    for stage in keys.iter().filter_map(|key| plan.stage(key)) {
        if let Err(error) = capability::check(plan, stage) {
            return faults::incapable(plan, stage, &error, global);
        }
    }
    let jobs =
        options.jobs.map(usize::from).or_else(|| std::thread::available_parallelism().ok().map(usize::from));
    let settings = exec::Options {
        jobs: jobs.unwrap_or(1),
        keep_going: true,
        selected: keys,
        reasons: Default::default(),
        single: Some(options.plan.clone()),
    };
    interrupt.work();
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    let (events, works) = (progress::events(global), works(&study));
    if let Err(error) = last_words::listen(Some(store.root().to_owned()), events.clone(), &interrupt) {
        output::complain(global, &format!("cannot prepare for crashes: {error}"), None);
        return Exit::Internal;
    }
    let workshop =
        Workshop { plan, store: &store, works: &works, events: events.as_ref(), interrupt: &interrupt };
    match exec::run(&workshop, &settings) {
        Err(error) => faults::store(global, &error),
        Ok(outcome) if outcome.interrupted => Exit::Interrupted,
        Ok(outcome) if !outcome.failures.is_empty() => Exit::StageFailed,
        Ok(_) => Exit::Ok,
    }
}
