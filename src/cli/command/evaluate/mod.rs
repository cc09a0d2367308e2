//! `specforge evaluate POLICY`: evaluates an exported policy without its spec, in any engine, at any command.
//! `specforge evaluate SPEC` finds the policy of a spec in the store.
//!
//! Episodes are as in a report: the same seed, command and engine give the same numbers.

mod conditions;
mod shown;
mod trained;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use crate::bounded::{self, ReadError};
use crate::cli::specs::{self, Findings, Variant};
use crate::cli::{Exit, Format, Global, interruption, output, progress};
use crate::crash;
use crate::deploy::{Policy, Transfer, Trust};
use crate::diag::{Diagnostic, Sources};
use crate::escape;
use crate::evaluate::follower::{Follower, LONG_EPISODE, Lasting, Measured};
use crate::exec::events::{Event, Events, JsonLines};
use crate::exec::works::episodes::{read_policy, transferred};
use crate::exec::{Interrupt, WorkError, last_words};
use crate::outcome::Evaluation;
use crate::robot::examine;
use conditions::Conditions;

/// Maximum size of a policy in bytes. A typical policy has half a megabyte.
const LARGEST: u64 = 64 << 20;

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The policy: a `policy.safetensors` of the stage `deploy.policy`, one of reports/policies/, or a spec
    /// (with the `--profile` and `--set` of its run), whose policy in the store is evaluated
    #[arg(value_name = "POLICY")]
    policy: PathBuf,
    #[command(flatten)]
    variant: Variant,
    /// Engines, separated by commas: rapier, mujoco, batch [default: the one that it was trained in]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    engine: Vec<String>,
    /// Physics rate in all engines [default: the training's in the engine that it was trained in, 2000 Hz in
    /// others]
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    rate: Option<String>,
    /// Episodes per engine and command
    #[arg(long, value_name = "N", default_value = "32", allow_negative_numbers = true)]
    episodes: String,
    /// Names the random streams of the episodes
    #[arg(long, value_name = "S", default_value = "1000", allow_negative_numbers = true)]
    seed: String,
    /// Forward speeds in m/s, separated by commas, each held for the whole of its episodes; may be repeated
    /// [default: the middle of the task's range]
    #[arg(
        long,
        visible_alias = "speeds",
        value_name = "V",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    command: Vec<String>,
    /// Longest duration of an episode, with its unit [default: the task's]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    time_limit: Option<String>,
    /// Another ground: `flat`, `slope,angle=3 deg`, `box_obstacle,height=1 cm,distance=60 cm`,
    /// `height_field,amplitude=2 cm`, each with any key of its kind
    #[arg(long, value_name = "KIND[,KEY=VALUE]...")]
    terrain: Option<String>,
    /// Draws the training's randomization in every episode
    #[arg(long)]
    randomize: bool,
    /// A push in every episode, with any key of the randomization `push`:
    /// `impulse=60 N*s,duration=0.1 s,at=6 s,direction=90 deg`
    #[arg(long, value_name = "KEY=VALUE,...", conflicts_with = "randomize")]
    push: Option<String>,
    /// Adds the training's noise to the observation
    #[arg(long)]
    noise: bool,
    /// Lets the policy act with the exploration of its training, not by its mean alone
    #[arg(long)]
    explore: bool,
    /// Runs a policy whose digest is missing or wrong; use it only if you know where the file comes from
    #[arg(long)]
    trust: bool,
    /// Threads; the numbers do not depend on them [default: the machine's cores]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
}

/// Evaluates and prints.
pub fn run(options: &Options, global: &Global) -> Exit {
    let interrupt = match interruption::listen(global, || {}) {
        Ok(interrupt) => interrupt,
        Err(exit) => return exit,
    };
    let path = match chosen(options, global) {
        Ok(path) => path,
        Err(exit) => return exit,
    };
    let policy = match readable(&path) {
        Ok(()) => read_policy(&path, if options.trust { Trust::User } else { Trust::Digest }),
        Err(diagnostic) => {
            specs::tell(&[Findings::of(Sources::default(), vec![*diagnostic]).in_file(&path)], global);
            return Exit::Invalid;
        }
    };
    let policy = match policy {
        Ok(policy) => policy,
        Err(error) => return unusable(&path, &error, global),
    };
    let (policy, conditions, odd) = match conditions::read(options, policy) {
        Ok(read) => read,
        Err(findings) => {
            specs::tell(&[*findings], global);
            return Exit::Invalid;
        }
    };
    specs::tell(&[of_robot(&policy).in_file(&path), odd], global);
    match evaluated(options, &policy, &conditions, &interrupt, global) {
        Ok(evaluations) => {
            shown::tell(&path, &policy, &conditions, evaluations, global);
            Exit::Ok
        }
        Err(error) => failed(&error, global),
    }
}

/// The file of the policy: as named, or that of the named spec. Reports errors.
fn chosen(options: &Options, global: &Global) -> Result<PathBuf, Exit> {
    if trained::is_spec(&options.policy) {
        return trained::policy(&options.policy, &options.variant, global);
    }
    if options.variant.options().varies() {
        let message = "`--profile` and `--set` select the run of a spec, and this is a policy";
        output::complain(global, message, Some("leave them out, or name the spec"));
        return Err(Exit::Usage);
    }
    Ok(options.policy.clone())
}

/// The findings about the policy's own robot. They are warnings, because the policy was trained with exactly
/// this robot.
fn of_robot(policy: &Policy) -> Findings {
    let issues = examine::issues(examine::all(&policy.blueprint.robot));
    let found =
        issues.into_iter().map(|issue| Diagnostic::warning(issue.code, issue.message).help(issue.help));
    Findings::of(Sources::default(), found.collect())
}

/// Fails if the path is not a file or is too large to be a policy.
fn readable(path: &Path) -> Result<(), Box<Diagnostic>> {
    let shown = crate::escape::file(path);
    let unreadable = |why: &str| Diagnostic::error("E0006", format!("cannot read `{shown}`: {why}"));
    let found = match bounded::bytes(path, LARGEST) {
        Ok(_) => return Ok(()),
        Err(ReadError::Folder) => {
            unreadable("it is a folder").help("name a policy in it, a .safetensors file")
        }
        Err(error @ ReadError::Special(_)) => {
            Diagnostic::error("E0007", format!("cannot read `{shown}`: {error}")).help("give a regular file")
        }
        Err(error) if error.is_absence() => {
            let advice = "policies lie in reports/policies/ and, as policy.safetensors, in the store's \
                folder `export`";
            Diagnostic::error("E0004", format!("file not found: `{shown}`")).help(advice)
        }
        Err(error) => unreadable(&error.to_string()),
    };
    Err(Box::new(found))
}

/// The exit code of an error, which is reported.
fn failed(error: &WorkError, global: &Global) -> Exit {
    if matches!(error, WorkError::Interrupted) {
        return interruption::tell(global);
    }
    let (code, help) = error.advice();
    output::fault(global, code, &error.to_string(), help.as_deref());
    Exit::StageFailed
}

/// Reports that the policy in a file cannot be used.
fn unusable(path: &Path, error: &WorkError, global: &Global) -> Exit {
    let (code, help) = error.advice();
    output::fault(global, code, &format!("{}: {error}", escape::file(path)), help.as_deref());
    Exit::StageFailed
}

/// Reports only warnings and failures, as JSON.
struct Urgent(JsonLines<std::io::Stderr>);

impl Events for Urgent {
    fn emit(&self, event: Event) {
        if matches!(event, Event::StageFailed { .. } | Event::Warning { .. }) {
            self.0.emit(event);
        }
    }
}

/// Evaluates all engines at all commands in turn; with `--format json`, reports each when it is done.
fn evaluated(
    options: &Options,
    policy: &Policy,
    conditions: &Conditions,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<Vec<Evaluation>, WorkError> {
    interrupt.work();
    let threads =
        options.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    // In JSON mode standard output is reserved for results.
    let events: Arc<dyn Events> = match global.format {
        Format::Json => Arc::new(Urgent(JsonLines::new(std::io::stderr()))),
        _ => progress::events(global),
    };
    last_words::listen(None, events.clone(), interrupt)
        .map_err(|error| WorkError::failed(format!("cannot prepare for crashes: {error}")))?;
    let mut evaluations = Vec::new();
    for transfer in &conditions.transfers {
        let stage = shown::place(&transfer.engine, transfer.protocol.command(None));
        let evaluation = followed(&stage, policy, transfer, threads, events.as_ref(), interrupt)?;
        if global.format == Format::Json {
            output::data(&shown::line(&evaluation).to_string());
        }
        evaluations.push(evaluation);
    }
    Ok(evaluations)
}

/// One evaluation, with its events.
fn followed(
    stage: &str,
    policy: &Policy,
    transfer: &Transfer,
    threads: usize,
    events: &dyn Events,
    interrupt: &Interrupt,
) -> Result<Evaluation, WorkError> {
    let _working = crash::working(crash::Work { label: stage.to_owned(), key: String::new() });
    let start = Instant::now();
    let total = transfer.protocol.conditions.len() as u64;
    let evaluation = transferred(policy, transfer, threads, &Told { stage, total, events, interrupt })?;
    let (stage, wall_s) = (stage.to_owned(), start.elapsed().as_secs_f64());
    events.emit(Event::StageFinished { stage, key: String::new(), cached: false, wall_s });
    Ok(evaluation)
}

/// Emits the events of an evaluation.
struct Told<'a> {
    stage: &'a str,
    total: u64,
    events: &'a dyn Events,
    interrupt: &'a Interrupt,
}

impl Follower for Told<'_> {
    fn takes(&self, _: usize, _: &Measured, done: usize) -> bool {
        let (stage, done, unit) = (self.stage.to_owned(), done as u64, "episodes".to_owned());
        self.events.emit(Event::Progress { stage, done, total: self.total, unit, note: String::new() });
        !self.interrupt.is_set()
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.is_set()
    }

    fn lasts(&self, index: usize, course: Lasting) {
        let (stage, help) = (Some(self.stage.to_owned()), Some(LONG_EPISODE.to_owned()));
        self.events.emit(Event::Warning { stage, code: None, message: course.sentence(index), help });
    }
}
