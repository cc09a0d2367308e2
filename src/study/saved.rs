//! A plan from the file that `plan --save` wrote.

use std::path::{Path, PathBuf};

use super::findings::{Findings, Log};
use super::plan::project;
use super::{Refusal, Study};
use crate::bounded;
use crate::diag::{Diagnostic, Sources};
use crate::escape;
use crate::plan::{Plan, Request, SavedError, StageKind};

/// How to save a plan.
const ADVICE: &str = "write the plan with `specforge plan SPEC --save PLAN.json`";

/// Whether a file is a plan, by its extension.
pub fn is_plan(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "json")
}

/// Reads a plan.
pub fn read(file: &Path, log: &mut Log) -> Result<Study, Refusal> {
    let text = match bounded::text(file, bounded::RECORD) {
        Err(error) if error.is_absence() => {
            let message = format!("file not found: `{}`", escape::file(file));
            let missing = Diagnostic::error("E0004", message).help(ADVICE.replace("the plan", "a plan"));
            log.add(Findings::of(Sources::default(), vec![missing]).in_file(file))?;
            return Err(Refusal::Invalid);
        }
        text => text.map_err(|error| no_plan(file, &error.to_string()))?,
    };
    let plan = match Plan::from_json(&text) {
        Ok(plan) => plan,
        Err(SavedError::Plan(error)) => {
            log.add(Findings::of(Sources::default(), vec![error.diagnostic(None)]).in_file(file))?;
            return Err(Refusal::Invalid);
        }
        Err(error @ SavedError::Format(_)) => return Err(no_plan(file, &error.to_string())),
    };
    let report = plan.stages().find(|stage| stage.kind == StageKind::Report);
    let name = report.map_or("report", |stage| stage.users[0].arm.as_str()).to_owned();
    let project = plan.arms.first().map_or_else(PathBuf::new, |arm| project_of(&arm.request));
    Ok(Study { plan, name, project, profiles: Vec::new() })
}

/// The project of a spec that a plan was made of: the folder in which its place begins.
fn project_of(request: &Request) -> PathBuf {
    let (spec, place) = (Path::new(&request.spec), Path::new(&request.place));
    let absolute = std::path::absolute(spec).unwrap_or_else(|_| spec.to_owned());
    let is_below = place.components().next().is_some() && absolute.ends_with(place);
    let root = absolute.ancestors().nth(place.components().count()).filter(|_| is_below);
    project(spec, root)
}

fn no_plan(file: &Path, reason: &str) -> Refusal {
    Refusal::Usage { message: format!("{}: {reason}", file.display()), advice: ADVICE.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_project_of_a_plan_is_that_of_its_spec() {
        let folder = tempfile::tempdir().unwrap();
        let spec = folder.path().join("specs/walks/a.toml").display().to_string();
        let request = |place: &str| Request { spec: spec.clone(), place: place.into(), ..Request::default() };
        assert_eq!(project_of(&request("specs/walks/a.toml")), folder.path());
        // Without a place that fits, it is the folder of the spec.
        for place in ["", "specs/b.toml"] {
            assert_eq!(project_of(&request(place)), folder.path().join("specs/walks"));
        }
    }
}
