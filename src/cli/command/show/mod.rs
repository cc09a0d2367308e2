//! `specforge show FILE`: a resolved spec. One file per view.

mod diff;
mod origins;
mod overview;
mod resolved;
mod signals;
mod suite;

use std::path::PathBuf;

use crate::check::{Checked, CheckedSuite};
use crate::cli::specs::{self, Variant};
use crate::cli::{Exit, Format, Global, output};
use crate::escape::terminal::Painted;
use crate::spec::suggest::nearest;

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
    /// The arm of a suite that is shown: `control=torque,stiffness=100 %`
    #[arg(long, value_name = "ARM")]
    arm: Option<String>,
    #[command(flatten)]
    variant: Variant,
}

/// Prints the requested view, by default an overview.
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
    if let (Some(arm), false) = (&options.arm, options.files.iter().any(|file| specs::is_suite(file))) {
        let message =
            format!("`--arm {arm}` is of a suite, and {} is a single spec", options.files[0].display());
        output::complain(global, &message, Some("leave `--arm` out, or name the suite"));
        return Exit::Usage;
    }
    let mut specs = Vec::new();
    for file in &options.files {
        let checked = match specs::is_suite(file) {
            true => specs::suite(file, &options.variant, global)
                .and_then(|suite| of_suite(suite, options, global)),
            false => {
                specs::require(file, &options.variant, global).map(|checked| Shown::Spec(Box::new(checked)))
            }
        };
        match checked {
            Ok(Shown::Spec(checked)) => specs.push(*checked),
            Ok(Shown::Whole(text)) => {
                output::data(&text);
                return Exit::Ok;
            }
            Err(exit) => return exit,
        }
    }
    let json = global.format == Format::Json;
    let plain = |text: &str| Painted::default().plain(text);
    let shown = match specs.as_slice() {
        [first, second] => plain(&diff::show(first, second, json)),
        [checked] if options.resolved => plain(&resolved::show(checked, json)),
        [checked] if options.origins => origins::show(checked, json, global),
        [checked] if options.signals => match signals::show(checked, json) {
            Some(shown) => plain(&shown),
            None => {
                output::complain(
                    global,
                    "an abstract spec has no signals",
                    Some("show a spec that extends it"),
                );
                return Exit::Invalid;
            }
        },
        [checked] => plain(&overview::show(checked, json)),
        _ => Painted::default(),
    };
    output::painted(&shown);
    Exit::Ok
}

/// What to show: a spec in one of the views, or a whole suite.
enum Shown {
    Spec(Box<Checked>),
    Whole(String),
}

/// An arm of a suite as a spec, or the suite if neither an arm nor a view of one is requested.
fn of_suite(checked: CheckedSuite, options: &Options, global: &Global) -> Result<Shown, Exit> {
    let names = || checked.arms.iter().map(|arm| arm.arm.name.as_str());
    let Some(wanted) = &options.arm else {
        if !(options.resolved || options.origins || options.signals || options.diff) {
            return suite::show(&checked, global.format == Format::Json).map(Shown::Whole);
        }
        let advice = format!("name one of its arms: `--arm \"{}\"`", names().next().unwrap_or("ARM"));
        output::complain(global, "this view is of a single spec", Some(&advice));
        return Err(Exit::Usage);
    };
    let Some(found) = checked.arms.iter().find(|arm| arm.arm.name == *wanted) else {
        let advice = match nearest(wanted, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`specforge show SUITE` lists the arms".to_owned(),
        };
        output::complain(global, &format!("the suite has no arm `{wanted}`"), Some(&advice));
        return Err(Exit::Usage);
    };
    Ok(Shown::Spec(Box::new(Checked {
        experiment: Some(found.arm.experiment.clone()),
        robot: found.robot.as_deref().cloned(),
        motion: found.motion.as_deref().cloned(),
        sources: checked.sources,
        sink: checked.sink,
        baselines: Vec::new(),
    })))
}

/// A JSON document as text.
fn pretty(value: &serde_json::Value) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}
