//! The command line: one file per command. Only this module reads arguments.
//!
//! To add a command, write a file with `Options` (its arguments) and `run(&Options, &Global) -> Exit`, then
//! add a variant of [`Command`] and a line in [`main`]. Data goes to standard output through
//! [`output::data`], everything else to standard error through [`output::note`] and [`output::complain`].

mod bench;
mod cache;
mod check;
mod completions;
mod doctor;
mod evaluate;
mod examples;
mod explain;
mod faults;
mod fmt;
pub mod index;
mod interruption;
mod list;
mod new;
mod next;
pub mod output;
mod overwrite;
mod pages;
mod plan;
mod power;
mod records;
mod report;
mod rewrite;
mod robot;
mod run;
mod schema;
mod show;
pub mod specs;
mod stage;
mod study;
mod trace;
mod why;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::exec::Interrupt;

const AFTER_HELP: &str = "\
Exit codes: 0 ok, 1 internal error, 2 wrong arguments, 3 the spec has errors, 4 a stage failed, 5 a claim \
failed \
(in a suite with `claims = \"count\"`), 6 interrupted.

Begin with `specforge check specs/atlas_run_torque.toml`, then `specforge run` the same file.";

/// Compiles robot-learning experiments: TOML specs in, checked and reproducible comparison reports out.
#[derive(Debug, Parser)]
#[command(name = "specforge", version, max_term_width = 110, after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Options of every command.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Options of every command")]
pub struct Global {
    /// Form of the output
    #[arg(long, global = true, value_enum, default_value = "human")]
    pub format: Format,
    /// Colours in messages
    #[arg(long, global = true, value_enum, default_value = "auto")]
    pub color: Color,
    /// Where artefacts are kept [default: .specforge beside Cargo.toml or the spec]
    #[arg(long, global = true, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// Print less
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// Whether warnings of specs are left to the commands that are about them.
    #[arg(skip)]
    pub errors_only: bool,
}

/// Forms of output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[value(alias = "text")]
    Human,
    /// For programs.
    Json,
    /// For GitHub's workflow annotations.
    Github,
    /// For Graphviz (`plan` only).
    Dot,
    /// For Mermaid, which Markdown pages draw (`plan` only).
    Mermaid,
    /// For MuJoCo (`robot show` only).
    Mjcf,
    /// For programs that read URDF (`robot show` only).
    Urdf,
}

/// When to colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// In a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// Exit codes. Other programs rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Success.
    Ok = 0,
    /// A bug in specforge.
    Internal = 1,
    /// Wrong arguments.
    Usage = 2,
    /// The spec has errors.
    Invalid = 3,
    /// A stage failed.
    StageFailed = 4,
    /// A claim failed.
    ClaimFailed = 5,
    /// Interrupted.
    Interrupted = 6,
}

/// The commands.
#[derive(Debug, Subcommand)]
enum Command {
    /// Checks specs: everything that can be known before a simulator starts
    #[command(after_help = examples::CHECK)]
    Check(check::Options),
    /// Shows the resolved spec: values, origins, signals
    #[command(after_help = examples::SHOW)]
    Show(show::Options),
    /// Shows the dataflow graph: stages, their inputs, whether they are cached, and why not
    #[command(after_help = examples::PLAN)]
    Plan(plan::Options),
    /// Runs specs: checks, trains, evaluates, deploys and writes the report
    #[command(after_help = examples::RUN)]
    Run(run::Options),
    /// Explains why a stage would run: the field that changed, with both values and their origins
    #[command(after_help = examples::WHY)]
    Why(why::Options),
    /// Measures how fast a spec trains on this machine: physics, rollout, learner, all together
    #[command(after_help = examples::BENCH)]
    Bench(bench::Options),
    /// Evaluates an exported policy without its spec: any engine, command, terrain, seed
    #[command(after_help = examples::EVALUATE)]
    Evaluate(evaluate::Options),
    /// Runs one stage of a saved plan
    #[command(after_help = examples::STAGE)]
    Stage(stage::Options),
    /// Writes a new spec or suite
    #[command(after_help = examples::NEW)]
    New(new::Options),
    /// Writes specs, suites, motions and robots in their canonical form
    #[command(after_help = examples::FMT)]
    Fmt(fmt::Options),
    /// Lists, verifies and cleans the store
    #[command(after_help = examples::CACHE)]
    Cache(cache::Options),
    /// Prints the JSON Schemas that editors check and complete specs with
    #[command(after_help = examples::SCHEMA)]
    Schema(schema::Options),
    /// Prints a shell's completion script: commands, options and names
    #[command(after_help = examples::COMPLETIONS)]
    Completions(completions::Options),
    /// Lists the registries and their kinds, or the codes, keys, units, robots or motions
    #[command(after_help = examples::LIST)]
    List(list::Options),
    /// Explains a code, a kind, a section, a key or a unit, a sweep or a claim
    #[command(after_help = examples::EXPLAIN)]
    Explain(explain::Options),
    /// Shows a robot, or imports one from a URDF or MJCF file
    #[command(after_help = examples::ROBOT)]
    Robot(robot::Options),
    /// Renders a report again from the store, without simulating
    #[command(after_help = examples::REPORT)]
    Report(report::Options),
    /// Shows which runs, stages, spec values and commits a figure or a table cell comes from
    #[command(after_help = examples::TRACE)]
    Trace(trace::Options),
    /// Reports what this machine lacks, and how to fix it
    #[command(after_help = examples::DOCTOR)]
    Doctor(doctor::Options),
}

/// Parses the arguments and runs the command.
pub fn main() -> Exit {
    Interrupt::outlive_file_size_limit();
    let given: Vec<_> = std::env::args_os().collect();
    let arguments = match Arguments::try_parse_from(&given) {
        Ok(arguments) => arguments,
        Err(error) => return output::arguments(error, &given),
    };
    let global = &arguments.global;
    let is_plan = matches!(arguments.command, Command::Plan(_));
    if matches!(global.format, Format::Dot | Format::Mermaid) && !is_plan {
        output::complain(global, "`--format dot` and `--format mermaid` are forms of `plan`", None);
        return Exit::Usage;
    }
    let exit = match &arguments.command {
        Command::Check(options) => check::run(options, global),
        Command::Show(options) => show::run(options, global),
        Command::Plan(options) => plan::run(options, global),
        Command::Run(options) => run::run(options, global),
        Command::Why(options) => why::run(options, global),
        Command::Bench(options) => bench::run(options, global),
        Command::Evaluate(options) => evaluate::run(options, global),
        Command::Stage(options) => stage::run(options, global),
        Command::New(options) => new::run(options, global),
        Command::Fmt(options) => fmt::run(options, global),
        Command::Schema(options) => schema::run(options, global),
        Command::Completions(options) => completions::run(options, global),
        Command::Cache(options) => cache::run(options, global),
        Command::List(options) => list::run(options, global),
        Command::Explain(options) => explain::run(options, global),
        Command::Robot(options) => robot::run(options, global),
        Command::Report(options) => report::run(options, global),
        Command::Trace(options) => trace::run(options, global),
        Command::Doctor(options) => doctor::run(options, global),
    };
    output::settled(exit)
}
