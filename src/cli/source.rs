//! From the arguments of `plan`, `run` and `why` to a plan: every spec and the specs that it compares
//! itself with, checked and lowered; a suite; or a plan from a file.

use std::path::{Path, PathBuf};

use super::comparison::{Comparison, lowered, project};
use super::specs::{self, Findings, Variant};
use super::{Exit, Global, output, suites};
use crate::check::{Checked, unrunnable};
use crate::plan::{Arm, Plan, Request, Shared};

/// What a plan is made from.
#[derive(Clone, Debug, clap::Args)]
pub struct Source {
    /// Specs to run and compare, or one plan that `plan --save` wrote
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub variant: Variant,
}

/// Reads, checks and lowers. `Err` is the exit code; everything has been said then.
pub fn read(source: &Source, global: &Global) -> Result<Comparison, Exit> {
    match source.files.as_slice() {
        [file] if file.extension().is_some_and(|ending| ending == "json") => saved(file, global),
        [file] if specs::is_suite(file) => suites::plan(file, &source.variant, global),
        files => {
            if let Some(suite) = files.iter().find(|file| specs::is_suite(file)) {
                let message = format!("{} is a suite, which is planned by itself", suite.display());
                output::complain(global, &message, Some("name one suite, or several specs"));
                return Err(Exit::Usage);
            }
            from_specs(files, &source.variant, global)
        }
    }
}

/// A plan from a file.
pub fn saved(file: &Path, global: &Global) -> Result<Comparison, Exit> {
    let text = std::fs::read_to_string(file).map_err(|error| error.to_string());
    let plan = text.and_then(|text| serde_json::from_str::<Plan>(&text).map_err(|error| error.to_string()));
    match plan {
        Ok(plan) => {
            let report = plan.stages().find(|stage| stage.kind == crate::plan::StageKind::Report);
            let name = report.map_or("report", |stage| stage.users[0].arm.as_str()).to_owned();
            let spec = plan.arms.first().map(|arm| PathBuf::from(&arm.request.spec)).unwrap_or_default();
            Ok(Comparison { plan, name, project: project(&spec, None) })
        }
        Err(error) => {
            let advice = Some("write the plan with `specforge plan SPEC --save PLAN.json`");
            output::complain(global, &format!("{}: not a plan: {error}", file.display()), advice);
            Err(Exit::Usage)
        }
    }
}

fn from_specs(files: &[PathBuf], variant: &Variant, global: &Global) -> Result<Comparison, Exit> {
    let mut arms: Vec<Arm> = Vec::new();
    let mut open: Vec<(PathBuf, bool)> = files.iter().map(|file| (file.clone(), true)).collect();
    let mut seen = Vec::new();
    let mut place = None;
    while !open.is_empty() {
        let (file, named) = open.remove(0);
        let identity = file.canonicalize().unwrap_or_else(|_| file.clone());
        if seen.contains(&identity) {
            continue;
        }
        seen.push(identity);
        let checked = specs::require(&file, variant, global)?;
        // A parent may be incomplete; what is wrong with running it is that it is one.
        let reason = checked.experiment.as_ref().and_then(|experiment| unrunnable(experiment, &checked.sources));
        if let Some(diagnostic) = reason {
            specs::tell(&[Findings { sources: checked.sources.clone(), diagnostics: vec![diagnostic] }], global);
            return Err(Exit::Invalid);
        }
        let Some((experiment, _)) = checked.sound() else { return Err(Exit::Invalid) };
        if named {
            // A spec that is only compared with does not bring its own comparisons.
            open.extend(experiment.compare.iter().map(|path| (path.clone(), false)));
        }
        place.get_or_insert_with(|| project(&file, experiment.root.as_deref()));
        arms.push(arm(&checked, &file, variant)?);
    }
    let project = place.unwrap_or_default();
    let named = &arms[..files.len().min(arms.len())];
    let name = named.iter().map(|arm| arm.name.as_str()).collect::<Vec<_>>().join("_vs_");
    lowered(&arms, (&name, None), project, global)
}

/// An arm of a checked spec.
fn arm(checked: &Checked, file: &Path, variant: &Variant) -> Result<Arm, Exit> {
    let (experiment, robot) = checked.sound().ok_or(Exit::Invalid)?;
    let request = Request {
        spec: file.display().to_string(),
        profile: variant.profile.clone(),
        assignments: variant.sets.clone(),
    };
    Ok(Arm {
        name: experiment.name.clone(),
        fields: experiment.table.clone(),
        origins: experiment.origin_texts(),
        robot: serde_json::to_value(robot).expect("a robot is plain data").into(),
        motion: checked.motion.clone().map(Shared::from),
        request,
        allow: experiment.allow.clone(),
        runs: None,
    })
}
