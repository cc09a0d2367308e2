//! The commands, a file each.
//!
//! To add a command, write a file with `Options` (its arguments) and `run(&Options, &Global) -> Exit`, then
//! add a variant of [`Command`] and a line in [`run()`].

mod bench;
mod cache;
mod check;
mod completions;
mod doctor;
mod evaluate;
mod explain;
mod fmt;
mod list;
mod new;
mod plan;
mod report;
mod robot;
mod run;
mod schema;
mod show;
mod stage;
mod trace;
mod why;

use clap::Subcommand;

use super::{Exit, Global, examples};

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Checks specs: everything that can be known before a simulator starts
    #[command(after_help = examples::CHECK)]
    Check(check::Options),
    /// Shows the resolved spec: values, origins, signals
    #[command(after_help = examples::SHOW)]
    Show(show::Options),
    /// Shows the dataflow graph: stages, their inputs, whether they are cached, why not, and how long they take
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

/// Runs a command.
pub fn run(command: &Command, global: &Global) -> Exit {
    match command {
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
    }
}
