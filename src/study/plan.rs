//! A plan with its project, from the arms of specs or of a suite.

use std::path::{Path, PathBuf};

use super::findings::{Findings, Log};
use super::{Refusal, Study};
use crate::check::Checked;
use crate::diag::{Sources, Span};
use crate::plan::{Arm, PlanError, ReportSource, ReportedSuite, Request, Shared, lower};
use crate::report::render;
use crate::report::template::Templates;
use crate::spec::section::Report;
use crate::spec::{LoadOptions, Section, Table};

/// The content of a page, besides its arms.
pub struct Reported<'a> {
    /// Its name.
    pub name: &'a str,
    /// The suite.
    pub suite: Option<ReportedSuite>,
    /// The specs that its arms are compared with, resolved.
    pub baselines: Vec<Table>,
}

/// The plan of arms with their report. `located` returns the sources of the specs and the position of an
/// error in them.
pub fn lowered(
    arms: &[Arm],
    Reported { name, suite, baselines }: Reported<'_>,
    project: PathBuf,
    located: impl Fn(&PlanError) -> (Sources, Option<Span>),
    log: &mut Log,
) -> Result<Study, Refusal> {
    let fields = suite.as_ref().map(|suite| &suite.fields).or(arms.first().map(|arm| &arm.fields));
    let templates = checked_templates(fields.ok_or(Refusal::Invalid)?, &project, log)?;
    match lower(arms, Some(&ReportSource { name: name.to_owned(), templates, suite, baselines })) {
        Ok(plan) => Ok(Study { plan, name: name.to_owned(), project, profiles: Vec::new() }),
        Err(error) => {
            let (sources, place) = located(&error);
            log.add(Findings::of(sources, vec![error.diagnostic(place)]))?;
            Err(Refusal::Invalid)
        }
    }
}

/// The templates for a project's reports.
pub fn templates(project: &Path) -> Templates {
    Templates::new(Some(project.join("templates")))
}

/// The digest of the report's templates. Errors in them are found here, before anything is trained.
fn checked_templates(fields: &Table, project: &Path, log: &mut Log) -> Result<String, Refusal> {
    let template = Section::new(fields).part::<Report>().map(|report| report.template).unwrap_or_default();
    let (templates, mut sources) = (templates(project), Sources::default());
    let diagnostics = render::check(&template, &templates, &mut sources);
    log.add(Findings::of(sources, diagnostics))?;
    // Embedded templates and rendering code change with the commit.
    Ok(format!("{} {}", templates.digest(&template), env!("SPECFORGE_COMMIT")))
}

/// An arm of a checked spec; `None` if it has errors.
pub fn plain_arm(checked: &Checked) -> Option<Arm> {
    let (experiment, robot) = checked.sound()?;
    Some(Arm {
        name: experiment.name.clone(),
        fields: experiment.table.clone(),
        origins: experiment.origin_texts(&checked.sources),
        robot: serde_json::to_value(robot).expect("a robot is plain data").into(),
        motion: checked.motion.clone().map(Shared::from),
        request: Request::default(),
        allow: experiment.allow.clone(),
        runs: None,
    })
}

/// The request: a file of a project and its variant.
pub fn request(file: &Path, project: &Path, options: &LoadOptions) -> Request {
    Request {
        spec: file.display().to_string(),
        place: place_in(project, file),
        profile: options.profile.clone(),
        assignments: options.sets.clone(),
        outside: options.allow_outside.iter().map(|folder| folder.display().to_string()).collect(),
    }
}

/// A spec's path in its project, independent of how the user wrote it; its file name if it lies elsewhere.
pub fn place_in(project: &Path, file: &Path) -> String {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let project = if project.as_os_str().is_empty() { Path::new(".") } else { project };
    let (project, file) = (real(project), real(file));
    let inside = file.strip_prefix(&project).ok().or(file.file_name().map(Path::new));
    inside.unwrap_or(&file).display().to_string()
}

/// The project's folder: the spec's nearest parent folder with a Cargo.toml, else with `robots/`, else the
/// spec's own folder.
pub fn project(spec: &Path, root: Option<&Path>) -> PathBuf {
    let here = std::path::absolute(spec).unwrap_or_else(|_| spec.to_owned());
    let crate_root = here.ancestors().skip(1).find(|folder| folder.join("Cargo.toml").is_file());
    let own = here.parent().map(Path::to_owned).unwrap_or_default();
    let absolute = crate_root.map(Path::to_owned).or_else(|| root.map(Path::to_owned)).unwrap_or(own);
    // Shorter in messages, but the same folder.
    match std::env::current_dir() {
        Ok(current) => absolute.strip_prefix(current).map(Path::to_owned).unwrap_or(absolute),
        Err(_) => absolute,
    }
}
