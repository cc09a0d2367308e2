//! `specforge show FILE`: a spec as it is resolved. One file per view.

mod diff;
mod origins;
mod overview;
mod resolved;
mod signals;

use std::path::PathBuf;

use super::specs::{self, Variant};
use super::{Exit, Format, Global, output};

/// Arguments of `show`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("view").args(["resolved", "origins", "signals", "diff"]))]
pub struct Options {
    /// The spec; two of them with `--diff`
    #[arg(value_name = "FILE", required = true, num_args = 1..=2)]
    files: Vec<PathBuf>,
    /// All values after inheritance, as a valid spec in its author's units
    #[arg(long)]
    resolved: bool,
    /// All values, each with where it comes from
    #[arg(long)]
    origins: bool,
    /// The policy's inputs and outputs with index, joint, unit and rate, and the low-level law
    #[arg(long)]
    signals: bool,
    /// The values in which two specs differ
    #[arg(long)]
    diff: bool,
    #[command(flatten)]
    variant: Variant,
}

/// Prints the view that was asked for; without one, an overview.
pub fn run(options: &Options, global: &Global) -> Exit {
    let wanted = if options.diff { 2 } else { 1 };
    if options.files.len() != wanted {
        let advice = "`specforge show FILE`, or `specforge show --diff A B`";
        output::complain(
            global,
            &format!("this view takes {wanted} spec(s), not {}", options.files.len()),
            Some(advice),
        );
        return Exit::Usage;
    }
    let mut specs = Vec::new();
    for file in &options.files {
        match specs::require(file, &options.variant, global) {
            Ok(checked) => specs.push(checked),
            Err(exit) => return exit,
        }
    }
    let json = global.format == Format::Json;
    let shown = match specs.as_slice() {
        [first, second] => diff::show(first, second, json),
        [checked] if options.resolved => resolved::show(checked, json),
        [checked] if options.origins => origins::show(checked, json, global),
        [checked] if options.signals => match signals::show(checked, json) {
            Some(shown) => shown,
            None => {
                output::complain(global, "an abstract spec has no signals", Some("show a spec that extends it"));
                return Exit::Invalid;
            }
        },
        [checked] => overview::show(checked, json),
        _ => String::new(),
    };
    output::data(&shown);
    Exit::Ok
}

/// A JSON document as text.
fn pretty(value: &serde_json::Value) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}
