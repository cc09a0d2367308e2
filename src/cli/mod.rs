//! The command line: arguments that all commands share, exit codes, and what several commands print.
//!
//! Each command is a file of [`command`]. Only the command line reads arguments. Data goes to standard output
//! through [`output::data`], everything else to standard error through [`output::note`] and
//! [`output::complain`].

mod command;
mod examples;
mod faults;
pub mod index;
mod interruption;
mod next;
pub mod output;
mod overwrite;
mod pages;
mod power;
mod progress;
mod records;
mod rewrite;
pub mod specs;
mod study;

use std::path::PathBuf;

use clap::{Args, Parser, ValueEnum};

use crate::exec::Interrupt;

use command::Command;

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
    let exit = command::run(&arguments.command, global);
    output::settled(exit)
}
