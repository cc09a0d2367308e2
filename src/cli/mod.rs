//! The command line: one file per command. Only this module reads arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Compiles robot-learning experiments: TOML specs in, checked and reproducible comparison reports out.
#[derive(Debug, Parser)]
#[command(name = "specforge", version, max_term_width = 110)]
pub struct Arguments {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Options of every command.
#[derive(Clone, Debug, Args)]
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
    /// Say less
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Forms of output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    Human,
    /// For programs.
    Json,
    /// For GitHub's workflow annotations.
    Github,
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

/// Exit codes; part of the contract with other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All is well.
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
enum Command {}

/// Parses the arguments and runs the command.
pub fn main() -> Exit {
    let arguments = Arguments::parse();
    let _ = &arguments.global;
    match arguments.command {}
}
