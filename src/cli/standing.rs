//! Whether a report is of the runs that its own command would make today.

use std::collections::BTreeSet;

use clap::Parser as _;

use super::source::{self, Source};
use super::{Arguments, Command, Exit, Global, output};
use crate::plan::{Plan, Stage, StageKind};
use crate::report::index::Standing;
use crate::report::sidecar::Sidecar;

/// Plans a report's command and compares the stages. None: the record names no command of this program. `Err`
/// is the exit code; everything has been said then.
pub fn of(report: &Sidecar, global: &Global) -> Result<Option<Standing>, Exit> {
    let Some(recorded) = recorded(report) else { return Ok(None) };
    if recorded.files.iter().any(|file| !file.is_file()) {
        return Ok(Some(Standing::WithoutSpecs));
    }
    // What is only suspicious is told when the spec is checked or run.
    let quieter = Global { errors_only: true, ..global.clone() };
    let comparison = source::read(&recorded, &quieter).inspect_err(|_| {
        let advice = "mend the specs, or delete the record and its page";
        let message = format!("the report {} was made by `{}`, which fails", report.report, report.command);
        output::complain(global, &message, Some(advice));
    })?;
    Ok(Some(compared(report, &comparison.plan)))
}

/// The specs and their variant that a record's command names; none when it is no command of this program.
pub fn recorded(report: &Sidecar) -> Option<Source> {
    let words = shlex::split(&report.command)?;
    match Arguments::try_parse_from(words) {
        Ok(Arguments { command: Command::Run(mut options), .. }) => {
            // A record is a file like any other: it permits nothing.
            options.source.variant.allow_outside.clear();
            Some(options.source)
        }
        _ => None,
    }
}

/// The report's stages beside those of a plan. Its own stage is left out: it follows the program that
/// renders.
fn compared(report: &Sidecar, plan: &Plan) -> Standing {
    let made: BTreeSet<&str> =
        report.arms.iter().flat_map(|arm| &arm.stages).map(|stage| stage.fingerprint.as_str()).collect();
    let today: Vec<_> = plan.stages().filter(|stage| stage.kind != StageKind::Report).collect();
    let lacks = |stage: &&&Stage| !made.contains(stage.fingerprint.to_string().as_str());
    let lacking: Vec<_> = today.iter().filter(lacks).collect();
    let mut kinds: Vec<String> = Vec::new();
    for stage in &lacking {
        let kind = stage.kind.facts().name;
        if !kinds.iter().any(|known| known == kind) {
            kinds.push(kind.to_owned());
        }
    }
    let (stages, lacking) = (today.len(), lacking.len());
    match (lacking, made.len() + lacking - stages) {
        (0, 0) => Standing::Current,
        (lacking, gone) => Standing::Earlier { kinds, lacking, stages, gone },
    }
}
