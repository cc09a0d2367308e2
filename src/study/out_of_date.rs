//! Finds pages whose specs were changed or deleted after the page was rendered. Needs the specs, not the
//! store.

use std::path::Path;

use super::standing;
use super::{Log, Study};
use crate::plan::StageKind;
use crate::report::claim;
use crate::report::gather::named;
use crate::report::index::Standing;
use crate::report::render_command::render_command;
use crate::report::sidecar::Sidecar;
use crate::report::{fields, wording};
use crate::spec::section::Header;
use crate::spec::{Claim, Value};

/// How a page differs from what its command would render now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfDate {
    /// What differs.
    pub reason: String,
    /// How to fix it.
    pub fix: String,
}

/// Most changed values that a reason names.
const SHOWN: usize = 5;

/// Compares a page in the folder `below` with its specs as they are now, under the page's own options: claims,
/// summary, seeds, the report's settings and all stages. `None` if they are those of the page, and if the
/// record names no files.
pub fn find(report: &Sidecar, below: &Path) -> Option<OutOfDate> {
    let (request, files) = (&report.request, report.request.paths());
    if request.is_empty() {
        return None;
    }
    if let Some(absent) = files.iter().find(|file| !file.is_file()) {
        let reason = format!("its spec {} does not exist", absent.display());
        let fix =
            "run this in the folder of its project, restore the spec, or delete page, record and figures";
        return Some(OutOfDate { reason, fix: fix.to_owned() });
    }
    let Ok(study) = Study::read(&files, &request.options(), &mut Log::default()) else {
        let reason = "its specs have errors now, so it is unknown whether it is up to date".to_owned();
        return Some(OutOfDate { reason, fix: format!("correct them: `{}`", request.command("check")) });
    };
    let changes: Vec<String> = [
        claims(report, &study),
        summary(report, &study),
        seeds(report, &study),
        settings(report, &study),
        stages(report, &study),
    ]
    .into_iter()
    .flatten()
    .collect();
    if changes.is_empty() {
        return None;
    }
    let again = render_command(report, below).unwrap_or_else(|| request.command("report"));
    let fix =
        format!("render it again: `{again}`, after `{}` where runs are missing", request.command("run"));
    Some(OutOfDate { reason: format!("it is out of date: {}", changes.join("; ")), fix })
}

/// The claims of a suite that the page does not have, and the other way round.
fn claims(report: &Sidecar, study: &Study) -> Option<String> {
    let suite = study.plan.suite.as_ref()?;
    let is_known = |claim: &Claim| report.claims.iter().any(|judged| claim::is_of(judged, claim));
    let is_there = |id: &str| suite.claims.iter().any(|claim| claim.id == id);
    let changed = suite.claims.iter().filter(|claim| !is_known(claim)).map(|claim| claim.id.as_str());
    let gone = report.claims.iter().map(|judged| judged.id.as_str()).filter(|id| !is_there(id));
    let names: Vec<String> = changed.chain(gone).map(|id| format!("`{id}`")).collect();
    let plural = if names.len() == 1 { "" } else { "s" };
    (!names.is_empty()).then(|| {
        format!(
            "the claim{plural} {} changed in {} since it was rendered",
            names.join(", "),
            report.request.files.join(", ")
        )
    })
}

/// The summary of a suite or of a single spec. Pages of several specs quote those of all; see [`settings`].
fn summary(report: &Sidecar, study: &Study) -> Option<String> {
    let plan = &study.plan;
    let stage = plan.stages().find(|stage| stage.kind == StageKind::Report).filter(|_| named(plan) == 1)?;
    let present = match stage.fields.get(Header::summary.name) {
        Some(Value::Text(text)) => text.as_str(),
        _ => "",
    };
    (report.summary != present).then(|| "its summary changed".to_owned())
}

/// The learning seeds of a suite.
fn seeds(report: &Sidecar, study: &Study) -> Option<String> {
    let (facts, suite) = (&report.facts, study.plan.suite.as_ref()?);
    let list = |seeds: &[u64]| match seeds {
        [] => "those of its specs".to_owned(),
        seeds => seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", "),
    };
    (facts.seeds != suite.seeds)
        .then(|| format!("the seeds are {} now, and were {}", list(&suite.seeds), list(&facts.seeds)))
}

/// The values of specs that no stage but the report's reads: the summary and the section `report`.
fn settings(report: &Sidecar, study: &Study) -> Option<String> {
    let plan = &study.plan;
    let is_setting = |path: &str| path == "summary" && named(plan) > 1 || path.starts_with(SETTINGS);
    let mut changed: Vec<String> = Vec::new();
    for present in plan.arms.iter().filter(|_| plan.suite.is_none()) {
        let Some(recorded) = report.arms.iter().find(|arm| arm.name == present.name) else { continue };
        let earlier = report.fields(recorded);
        let table = present.fields.table();
        let now: Vec<_> = fields::flat(&table);
        let value =
            |path: &String| now.iter().find(|(own, _)| own == path).map(|(_, value)| wording::value(value));
        let paths =
            earlier.keys().map(|path| (*path).clone()).chain(now.iter().map(|(path, _)| path.clone()));
        for path in paths.filter(|path| is_setting(path)) {
            let before = earlier.get(&path).map(|field| field.value.clone());
            if value(&path) != before && !changed.contains(&path) {
                changed.push(path);
            }
        }
    }
    changed.sort();
    let shown: Vec<String> = changed.iter().take(SHOWN).map(|path| format!("`{path}`")).collect();
    (!shown.is_empty()).then(|| format!("{} changed", shown.join(", ")))
}

/// The section of the report's settings, as the beginning of a path.
const SETTINGS: &str = "report.";

/// The stages that the page was rendered from and that its command would make now.
fn stages(report: &Sidecar, study: &Study) -> Option<String> {
    let is_complete = report.facts.complete == report.facts.runs;
    match standing::compared(report, &study.plan) {
        // The runs that were missing from the page are missing still, and the others are the same.
        Standing::Earlier { gone: 0, .. } if !is_complete => None,
        Standing::Earlier { lacking: 0, gone, .. } => {
            Some(format!("{gone} of its stages are no longer made"))
        }
        Standing::Earlier { lacking, stages, .. } if lacking == stages => {
            Some("all its stages differ: values that they read, or the program, changed".to_owned())
        }
        Standing::Earlier { kinds, lacking, stages, .. } => Some(format!(
            "{lacking} of {stages} stages differ ({}): a value that they read, or the program, changed",
            kinds.join(", ")
        )),
        Standing::Current | Standing::WithoutSpecs => None,
    }
}
