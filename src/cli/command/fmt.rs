//! `specforge fmt FILE...`: writes files in canonical form, or lists those that are not.

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::bounded;
use crate::cli::specs::{self, Findings};
use crate::cli::{Exit, Format, Global, output, rewrite};
use crate::diag::{Sink, Sources};
use crate::format::{Order, Sort, format};
use crate::safe_fs;
use crate::syntax::{Disk, file, parse};

/// Arguments of `fmt`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Specs, suites, motions and robots, or folders of them; `-` is standard input
    #[arg(value_name = "FILE|DIR", required = true)]
    files: Vec<PathBuf>,
    /// Changes nothing; prints what would change and ends with 3 if anything would
    #[arg(long)]
    check: bool,
}

/// The result for one file.
enum Outcome {
    /// It is in canonical form.
    Clean,
    /// It is not; the text before and after formatting.
    Changed(String, String),
    /// It cannot be parsed; the findings say why.
    Broken(Findings),
}

/// Formats every file.
pub fn run(options: &Options, global: &Global) -> Exit {
    let order = Order::of_this_edition();
    if options.files == [Path::new("-")] {
        return standard_input(&order, options.check, global);
    }
    let files = match specs::toml_files(&options.files, global) {
        Ok(files) => files,
        Err(exit) => return exit,
    };
    if files.is_empty() {
        output::complain(
            global,
            "there is no TOML file in the folders named",
            Some("`specforge fmt specs robots`"),
        );
        return Exit::Usage;
    }
    let mut tally = Tally::default();
    for path in &files {
        let named = options.files.contains(path);
        match examine(path, named, &order) {
            None => {}
            Some(Outcome::Clean) => tally.clean += 1,
            Some(Outcome::Broken(findings)) => tally.broken.push(findings),
            Some(Outcome::Changed(before, after)) => {
                if options.check {
                    show(path, &before, &after, global);
                } else if let Err(error) = safe_fs::replace(path, after.as_bytes()) {
                    let message = format!("{} cannot be written: {error}", path.display());
                    let advice =
                        "change the permissions of the file and its folder, or see what --check finds";
                    output::complain(global, &message, Some(advice));
                    return Exit::StageFailed;
                }
                tally.changed.push(path.clone());
            }
        }
    }
    tally.report(options.check, global)
}

/// Formats standard input to standard output.
fn standard_input(order: &Order, check: bool, global: &Global) -> Exit {
    let text = match bounded::text_of(std::io::stdin().lock(), bounded::WRITTEN) {
        Ok(text) => text,
        Err(error) => {
            let advice = "give one TOML file, at most 1 MiB of UTF-8 text";
            output::complain(global, &format!("cannot read standard input: {error}"), Some(advice));
            return Exit::Invalid;
        }
    };
    let path = Path::new("standard input");
    let mut tally = Tally::default();
    match outcome(path, text.clone(), true, order) {
        Some(Outcome::Broken(findings)) => tally.broken.push(findings),
        Some(Outcome::Changed(before, after)) if check => {
            show(path, &before, &after, global);
            tally.changed.push(path.to_owned());
        }
        Some(Outcome::Changed(_, after)) => output::data(&after),
        _ if check => {}
        _ => output::data_if_any(&text),
    }
    tally.verdict(check, global)
}

/// Reads and formats a file; `None` for an unrelated file in a folder.
fn examine(path: &Path, named: bool, order: &Order) -> Option<Outcome> {
    match file::read(&Disk, path) {
        Ok(text) => outcome(path, text, named, order),
        Err(error) => Some(Outcome::Broken(Findings::of(Sources::default(), vec![error]).in_file(path))),
    }
}

/// Formats a text. A file that was named explicitly is treated as a spec unless it looks like something else.
fn outcome(path: &Path, text: String, named: bool, order: &Order) -> Option<Outcome> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(path, text.as_str());
    let Some(document) = parse(&sources, source, &mut sink) else {
        return Some(Outcome::Broken(Findings::of(sources, sink.diagnostics).in_file(path)));
    };
    let sort = document.table().and_then(Sort::of).or(named.then_some(Sort::Spec))?;
    let formatted = format(&text, sort, order);
    Some(if formatted == text { Outcome::Clean } else { Outcome::Changed(text, formatted) })
}

/// Prints the changes in the format of `diff -u`.
fn show(path: &Path, before: &str, after: &str, global: &Global) {
    if global.format == Format::Json {
        return;
    }
    output::data(&rewrite::difference(path, before, after));
}

/// Counts of the results.
#[derive(Default)]
struct Tally {
    clean: usize,
    changed: Vec<PathBuf>,
    broken: Vec<Findings>,
}

impl Tally {
    fn report(&self, check: bool, global: &Global) -> Exit {
        let verb = if check { "would be rewritten" } else { "rewritten" };
        if global.format != Format::Json {
            for path in self.changed.iter().filter(|_| !check) {
                output::note(global, &format!("{}: {verb}", output::shown(path)));
            }
            let (changed, clean, broken) = (self.changed.len(), self.clean, self.broken.len());
            let broken = if broken == 0 { String::new() } else { format!(", {broken} left alone") };
            output::note(global, &format!("{changed} {verb}, {clean} already in order{broken}"));
        }
        self.verdict(check, global)
    }

    fn verdict(&self, check: bool, global: &Global) -> Exit {
        specs::print(&self.broken, global);
        if global.format == Format::Json {
            let mut document = specs::json(&self.broken);
            document["changed"] = json!(self.changed);
            document["clean"] = json!(self.clean);
            output::json(&document);
        }
        if self.broken.is_empty() && (self.changed.is_empty() || !check) { Exit::Ok } else { Exit::Invalid }
    }
}
