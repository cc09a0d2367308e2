//! Checks whether a report matches the runs that its own command would make today.

use std::collections::BTreeSet;

use super::{Log, Refusal, Study};
use crate::plan::{Plan, Stage, StageKind};
use crate::report::index::Standing;
use crate::report::sidecar::Sidecar;

/// Plans a report's command and compares the stages. `None`: the record names no files.
pub fn of(report: &Sidecar, log: &mut Log) -> Result<Option<Standing>, Refusal> {
    let files = report.request.paths();
    if files.is_empty() {
        return Ok(None);
    }
    if files.iter().any(|file| !file.is_file()) {
        return Ok(Some(Standing::WithoutSpecs));
    }
    let study = Study::read(&files, &report.request.options(), log)?;
    Ok(Some(compared(report, &study.plan)))
}

/// Compares the report's stages with those of a plan. The report stage is excluded, as it depends on the
/// program that renders.
pub(super) fn compared(report: &Sidecar, plan: &Plan) -> Standing {
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
