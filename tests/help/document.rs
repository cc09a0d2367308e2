//! `docs/reference/commands.md`: what `--help` says of every command, as one page.

use std::fmt::Write as _;

use clap::{Arg, Command, CommandFactory};
use specforge::cli::Arguments;

const INTRODUCTION: &str = "\
# Commands

What `specforge --help` and `specforge COMMAND --help` print, as one page. It is generated from the program.
";

/// The whole page.
pub fn page() -> String {
    let mut program = Arguments::command();
    program.build();
    let mut page = INTRODUCTION.to_owned();
    let _ =
        write!(page, "\n{}\n\n## Commands\n\n| command | what it does |\n|---|---|\n", after_help(&program));
    for command in commands(&program) {
        let name = command.get_name();
        let _ = writeln!(page, "| [{name}](#{name}) | {} |", cell(&about(command)));
    }
    let everywhere: Vec<&Arg> = program.get_arguments().filter(|argument| argument.is_global_set()).collect();
    let _ = write!(page, "\n## Options of every command\n\n{}", table(&everywhere));
    for command in commands(&program) {
        page += &chapter(command, command.get_name(), "##");
    }
    page
}

/// The commands below a command, without clap's own.
fn commands(command: &Command) -> impl Iterator<Item = &Command> {
    command.get_subcommands().filter(|command| command.get_name() != "help")
}

/// A command and the commands below it.
fn chapter(command: &Command, name: &str, level: &str) -> String {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ");
    let mut text = format!("\n{level} {name}\n\n{}.\n\n```text\n{usage}\n```\n", about(command));
    let own = |argument: &&Arg| !argument.is_global_set() && !argument.is_hide_set();
    let own: Vec<&Arg> = command
        .get_arguments()
        .filter(own)
        .filter(|argument| !["help", "version"].contains(&argument.get_id().as_str()))
        .collect();
    if !own.is_empty() {
        let _ = write!(text, "\n{}", table(&own));
    }
    for sub in commands(command) {
        text += &chapter(sub, &format!("{name} {}", sub.get_name()), &format!("{level}#"));
    }
    let after = after_help(command);
    if !after.is_empty() {
        let _ = write!(text, "\n{after}\n");
    }
    text
}

fn about(command: &Command) -> String {
    command.get_about().map(ToString::to_string).unwrap_or_default().trim_end_matches('.').to_owned()
}

/// The text after the options: examples as a block, everything else as paragraphs.
fn after_help(command: &Command) -> String {
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let paragraphs = text.split("\n\n").map(|paragraph| {
        let (heading, examples) = paragraph.split_once('\n').unwrap_or((paragraph, ""));
        if heading == "Examples:" {
            let lines = examples.lines().map(|line| format!("$ {}\n", line.trim_start()));
            format!("```console\n{}```", lines.collect::<String>())
        } else {
            paragraph.replace('\n', " ")
        }
    });
    paragraphs.collect::<Vec<_>>().join("\n\n").trim().to_owned()
}

/// Arguments and options as a table.
fn table(arguments: &[&Arg]) -> String {
    let mut text = String::from("| argument or option | meaning |\n|---|---|\n");
    for argument in arguments {
        let _ = writeln!(text, "| {} | {} |", cell(&spelling(argument)), cell(&meaning(argument)));
    }
    text
}

/// How an argument is written: `-s, --set PATH=VALUE`, `SPEC...`.
fn spelling(argument: &Arg) -> String {
    let many = argument.get_num_args().is_some_and(|count| count.max_values() > 1)
        || (argument.is_positional() && matches!(argument.get_action(), clap::ArgAction::Append));
    let names = argument.get_value_names().unwrap_or_default().iter().map(ToString::to_string);
    let values = if argument.get_action().takes_values() {
        names.collect::<Vec<_>>().join(" ")
    } else {
        String::new()
    };
    let values = if many { format!("{values}...") } else { values };
    let short = argument.get_short().map(|short| format!("`-{short}`, ")).unwrap_or_default();
    match argument.get_long() {
        Some(long) => {
            let aliases = argument.get_visible_aliases().unwrap_or_default();
            let aliases: String = aliases.iter().map(|alias| format!(", `--{alias}`")).collect();
            format!("{short}`--{}`{aliases}", format!("{long} {values}").trim_end())
        }
        None => format!("`{values}`"),
    }
}

/// The help of an argument, with its values and its default.
fn meaning(argument: &Arg) -> String {
    let mut text = argument.get_help().map(ToString::to_string).unwrap_or_default();
    if !argument.get_action().takes_values() {
        return text;
    }
    let values: Vec<String> = argument
        .get_possible_values()
        .iter()
        .filter(|value| !value.is_hide_set())
        .map(|value| match value.get_help() {
            Some(help) => {
                let help = help.to_string();
                let (first, rest) = help.split_at(help.chars().next().map_or(0, char::len_utf8));
                let help = format!("{}{rest}", first.to_lowercase());
                format!("`{}` {}", value.get_name(), help.trim_end_matches('.'))
            }
            None => format!("`{}`", value.get_name()),
        })
        .collect();
    if !values.is_empty() {
        let _ = write!(text, ": {}", values.join("; "));
    }
    let defaults: Vec<_> =
        argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    if !defaults.is_empty() {
        let _ = write!(text, " [default: {}]", defaults.join(", "));
    }
    text
}

/// A text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('\n', " ").replace('|', "\\|").replace('<', "&lt;")
}
