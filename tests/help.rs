//! Every `--help` ends with examples that the program understands and with its exit codes,
//! `docs/reference/commands.md` says what `--help` says, and `specforge completions` writes a script that
//! completes.
//!
//! `SPECFORGE_BLESS=1 cargo test --test help` rewrites the document.

#[path = "help/document.rs"]
mod document;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use clap::{CommandFactory, Parser};
use specforge::cli::Arguments;

fn specforge(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .expect("the program can be started")
}

/// The words of a shell line, up to a redirection.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().take_while(|word| *word != ">").collect()
}

#[test]
fn every_command_has_examples_that_it_understands_and_says_its_exit_codes() {
    let command = Arguments::command();
    let mut count = 0;
    for sub in command.get_subcommands() {
        let help = sub.get_after_help().map(ToString::to_string).unwrap_or_default();
        let name = sub.get_name();
        assert!(help.contains("Exit codes: 0 "), "{name} says its exit codes");
        let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  specforge ")).collect();
        assert!(
            examples.iter().any(|line| words(line).get(1) == Some(&name)),
            "{name} has an example of itself"
        );
        for line in examples {
            if let Err(error) = Arguments::try_parse_from(words(line)) {
                panic!("an example of {name}: {line}: {error}");
            }
            for file in words(line)
                .into_iter()
                .filter(|word| word.starts_with("specs/") || word.starts_with("robots/"))
            {
                let written = ["new", "schema"].contains(&name);
                assert!(
                    written || Path::new(env!("CARGO_MANIFEST_DIR")).join(file).exists(),
                    "{name} names {file}"
                );
            }
            count += 1;
        }
    }
    assert!(count >= 30, "{count} examples");
}

#[test]
fn the_document_of_the_commands_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/commands.md");
    let page = document::page();
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, &page).expect("docs/ is writable");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "docs/reference/commands.md is stale: run SPECFORGE_BLESS=1 cargo test --test help"
    );
}

#[test]
fn the_document_has_every_command_and_every_option() {
    fn missing(command: &clap::Command, name: &str, page: &str) -> Vec<String> {
        let own = (!page.contains(&format!("# {name}\n"))).then(|| name.to_owned());
        let options = command.get_arguments().filter_map(clap::Arg::get_long);
        let options = options.filter(|long| !page.contains(&format!("`--{long}"))).map(str::to_owned);
        let below = command.get_subcommands().filter(|sub| sub.get_name() != "help");
        let below = below.flat_map(|sub| missing(sub, &format!("{name} {}", sub.get_name()), page));
        own.into_iter().chain(options).chain(below).collect()
    }
    let command = Arguments::command();
    let page = document::page();
    let commands = command.get_subcommands().filter(|sub| sub.get_name() != "help");
    let missing: Vec<String> = commands.flat_map(|sub| missing(sub, sub.get_name(), &page)).collect();
    assert!(missing.is_empty(), "docs/reference/commands.md lacks {missing:?}");
}

#[test]
fn help_fits_into_110_columns() {
    for sub in Arguments::command().get_subcommands() {
        let output = specforge(&[sub.get_name(), "--help"]);
        assert_eq!(output.status.code(), Some(0));
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            assert!(line.chars().count() <= 118, "{}: {line}", sub.get_name());
        }
    }
}

/// What bash offers after a line, or nothing where there is no bash.
fn offered(line: &[&str]) -> Option<Vec<String>> {
    let script = specforge(&["completions", "bash"]).stdout;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("specforge.bash");
    fs::write(&path, &script).expect("written");
    let quoted: Vec<String> = line.iter().map(|word| format!("'{word}'")).collect();
    let program = format!(
        "source '{}'; COMP_WORDS=({}); COMP_CWORD={}; _specforge specforge '{}' '{}'; printf '%s\\n' \
         \"${{COMPREPLY[@]}}\"",
        path.display(),
        quoted.join(" "),
        line.len() - 1,
        line.last().expect("a word"),
        line[line.len() - 2],
    );
    let output = Command::new("bash").args(["--norc", "-c", &program]).output().ok()?;
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
}

#[test]
fn bash_completes_commands_options_registries_robots_and_profiles() {
    let cases: [(&[&str], &str); 9] = [
        (&["specforge", "expl"], "explain"),
        (&["specforge", "run", "--prof"], "--profile"),
        (&["specforge", "run", "--profile", ""], "quick"),
        (&["specforge", "list", "rew"], "reward"),
        (&["specforge", "explain", "E020"], "E0203"),
        (&["specforge", "new", "--robot", "at"], "atlas"),
        (&["specforge", "check", "--format", ""], "github"),
        (&["specforge", "evaluate", "--engine", "mu"], "mujoco"),
        (&["specforge", "evaluate", "--terrain", ""], "slope"),
    ];
    for (line, expected) in cases {
        let Some(offered) = offered(line) else { return };
        assert!(offered.iter().any(|word| word == expected), "{line:?}: {offered:?}");
    }
}

#[test]
fn every_shell_has_a_script() {
    for shell in ["bash", "zsh", "fish"] {
        let output = specforge(&["completions", shell]);
        assert_eq!(output.status.code(), Some(0));
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        // The script for fish knows options and their values, but no values of other arguments.
        let known = if shell == "fish" { ["tocabi", "doctor"] } else { ["velocity_tracking", "doctor"] };
        assert!(known.iter().all(|word| script.contains(word)), "{shell}");
    }
}
