//! `specforge completions SHELL`: the script that completes commands, options and, where known, values.

use std::path::Path;

use clap::builder::PossibleValuesParser;
use clap::{Command, CommandFactory};
use clap_complete::Shell;

use super::list::LISTS;
use crate::cli::{Arguments, Exit, Global, output};
use crate::diag::codes::PAGES;
use crate::kinds::keys::keys;
use crate::kinds::reference::registries;
use crate::kinds::terrain;
use crate::kinds::vocabulary::vocabulary;
use crate::quantity::Measure;
use crate::quantity::unit::UNITS;
use crate::scaffold::{actions, parents, tasks};
use crate::sim::ENGINES;
use crate::spec::folder;
use crate::spec::load::robots;
use crate::syntax::Disk;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The shell
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Prints the script.
pub fn run(options: &Options, _: &Global) -> Exit {
    let mut command = with_values(Arguments::command());
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut command, "specforge", &mut script);
    output::data(&String::from_utf8_lossy(&script));
    Exit::Ok
}

/// Adds the values known when the script is written: names of registries, kinds, robots and profiles. Only
/// the script uses them; parsing accepts other values too.
fn with_values(command: Command) -> Command {
    let names = Names::of_this_project();
    let command = command
        .mut_subcommand("list", |list| values(list, "what", &names.lists))
        .mut_subcommand("explain", |explain| values(explain, "word", &names.words))
        .mut_subcommand("robot", |robot| {
            robot.mut_subcommand("show", |show| values(show, "robot", &names.robots))
        })
        .mut_subcommand("evaluate", |evaluate| {
            values(values(evaluate, "engine", &names.engines), "terrain", &names.terrains)
        })
        .mut_subcommand("new", |new| {
            let new = values(new, "robot", &names.robots);
            values(values(new, "task", &names.tasks), "action", &names.actions)
        });
    let with_profile: Vec<String> = command
        .get_subcommands()
        .filter(|sub| sub.get_arguments().any(|argument| argument.get_id() == "profile"))
        .map(|sub| sub.get_name().to_owned())
        .collect();
    with_profile.into_iter().fold(command, |command, sub| {
        command.mut_subcommand(sub, |sub| values(sub, "profile", &names.profiles))
    })
}

/// Adds values for an argument. The names are leaked; the program ends after printing the script.
fn values(command: Command, argument: &'static str, names: &[String]) -> Command {
    let names: Vec<&'static str> = names.iter().map(|name| &*name.clone().leak()).collect();
    command.mut_arg(argument, |argument| argument.value_parser(PossibleValuesParser::new(names)))
}

/// Names to complete.
struct Names {
    lists: Vec<String>,
    words: Vec<String>,
    robots: Vec<String>,
    engines: Vec<String>,
    terrains: Vec<String>,
    tasks: Vec<String>,
    actions: Vec<String>,
    profiles: Vec<String>,
}

impl Names {
    /// The built-in names, and the robots of the project that contains the working folder.
    fn of_this_project() -> Self {
        let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect::<Vec<String>>();
        let registries = registries();
        let root = folder::root(&Disk, Path::new("new.toml"));
        let mut words: Vec<String> = PAGES.iter().map(|page| page.code.to_owned()).collect();
        words.extend(registries.iter().map(|registry| registry.name.to_owned()));
        words.extend(
            registries.iter().flat_map(|registry| registry.kinds.iter().map(|kind| kind.name.to_owned())),
        );
        words.extend(keys().into_iter().map(|key| key.path));
        words.extend(UNITS.iter().filter(|unit| unit.symbol != "%").map(|unit| unit.symbol.to_owned()));
        words.extend(Measure::ALL.map(|measure| measure.unit().to_owned()));
        words.sort();
        words.dedup();
        Self {
            lists: registries.iter().map(|registry| registry.name).chain(LISTS).map(str::to_owned).collect(),
            words,
            robots: robots(&vocabulary()).names(&Disk, root.as_deref()),
            engines: owned(ENGINES.to_vec()),
            terrains: owned(terrain::KINDS.iter().map(|kind| kind.name).collect()),
            tasks: owned(tasks()),
            actions: owned(actions()),
            profiles: profiles(),
        }
    }
}

/// The profiles of the built-in parents, sorted.
fn profiles() -> Vec<String> {
    let mut names = std::collections::BTreeSet::new();
    for (_, text) in parents() {
        let parent: toml::Table = toml::from_str(text).unwrap_or_default();
        let profiles = parent.get("profile").and_then(toml::Value::as_table);
        names.extend(profiles.into_iter().flat_map(|profiles| profiles.keys().cloned()));
    }
    names.into_iter().collect()
}
