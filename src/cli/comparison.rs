//! A plan with its project and its store, made of the arms of specs or of a suite.

use std::path::{Path, PathBuf};

use super::specs::{self, Findings};
use super::{Exit, Global, output, run};
use crate::diag::{Sources, Span};
use crate::exec::Store;
use crate::plan::{Arm, Plan, PlanError, ReportSource, ReportedSuite, lower};
use crate::report::paths;
use crate::report::render;
use crate::report::template::Templates;
use crate::spec::section::Report;
use crate::spec::{Section, Table};

/// A plan and where it belongs.
pub struct Comparison {
    /// The plan.
    pub plan: Plan,
    /// The name of the report.
    pub name: String,
    /// The folder of `reports/` and `.specforge/`.
    pub project: PathBuf,
    /// The profiles that could have been chosen; none of a plan from a file.
    pub profiles: Vec<String>,
}

impl Comparison {
    /// The store: what the user named, or `.specforge` in the project's folder. `Err` is the exit code when
    /// its mark is damaged or of another layout, or the folder is somebody else's; it has been said then.
    pub fn store(&self, global: &Global) -> Result<Store, Exit> {
        let store = Store::at(global.store.clone().unwrap_or_else(|| self.project.join(".specforge")));
        store.identity().map_err(|error| run::complain(global, &error))?;
        Ok(store)
    }

    /// The folder of the page, when the user names no other: below `reports/` as the (first) spec is below
    /// `specs/`.
    pub fn reports(&self) -> PathBuf {
        let place = self.plan.arms.first().map_or("", |arm| arm.request.place.as_str());
        self.project.join("reports").join(paths::page_folder(place))
    }
}

/// Where the report is written: into the folder that the user named, or into its own below the project's
/// `reports`. `Err` is the exit code when that is no folder; it has been said then, before anything is worked
/// on.
pub fn reports(chosen: Option<&Path>, comparison: &Comparison, global: &Global) -> Result<PathBuf, Exit> {
    let folder = chosen.map_or_else(|| comparison.reports(), Path::to_owned);
    if folder.exists() && !folder.is_dir() {
        let message = format!("reports cannot be written into {}, which is a file", folder.display());
        output::complain(global, &message, Some("name a folder: `--reports DIR`"));
        return Err(Exit::Usage);
    }
    Ok(folder)
}

/// What a page is of, beside its arms.
pub struct Reported<'a> {
    /// Its name.
    pub name: &'a str,
    /// The suite.
    pub suite: Option<ReportedSuite>,
    /// The specs that its arms are compared with, resolved.
    pub baselines: Vec<Table>,
}

/// The plan of arms, with their report. `located` gives the texts of the specs and the place in them that is
/// to blame.
pub fn lowered(
    arms: &[Arm],
    Reported { name, suite, baselines }: Reported<'_>,
    project: PathBuf,
    located: impl Fn(&PlanError) -> (Sources, Option<Span>),
    global: &Global,
) -> Result<Comparison, Exit> {
    let fields = suite.as_ref().map(|suite| &suite.fields).or(arms.first().map(|arm| &arm.fields));
    let templates = checked_templates(fields.ok_or(Exit::Invalid)?, &project, global)?;
    match lower(arms, Some(&ReportSource { name: name.to_owned(), templates, suite, baselines })) {
        Ok(plan) => Ok(Comparison { plan, name: name.to_owned(), project, profiles: Vec::new() }),
        Err(error) => {
            let (sources, place) = located(&error);
            specs::tell(&[Findings::of(sources, vec![error.diagnostic(place)])], global);
            Err(Exit::Invalid)
        }
    }
}

/// The templates that a project's reports are rendered with.
pub fn templates(project: &Path) -> Templates {
    Templates::new(Some(project.join("templates")))
}

/// The digest of the templates that the report is rendered with. A mistake in its template is found here,
/// before anything is trained.
fn checked_templates(fields: &Table, project: &Path, global: &Global) -> Result<String, Exit> {
    let template = Section::new(fields).at(Report::template).unwrap_or_else(|| "run.md.j2".to_owned());
    let (templates, mut sources) = (templates(project), Sources::default());
    let diagnostics = render::check(&template, &templates, &mut sources);
    if specs::tell(&[Findings::of(sources, diagnostics)], global) {
        return Err(Exit::Invalid);
    }
    // The copies inside the program and the code that renders change with the commit.
    Ok(format!("{} {}", templates.digest(&template), env!("SPECFORGE_COMMIT")))
}

/// A spec's path in its project, the same however the user named the file; its name where it lies elsewhere.
pub fn place_in(project: &Path, file: &Path) -> String {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let project = if project.as_os_str().is_empty() { Path::new(".") } else { project };
    let (project, file) = (real(project), real(file));
    let inside = file.strip_prefix(&project).ok().or(file.file_name().map(Path::new));
    inside.unwrap_or(&file).display().to_string()
}

/// The project's folder: the nearest around the spec with a Cargo.toml, else with `robots/`, else the
/// spec's own.
pub fn project(spec: &Path, root: Option<&Path>) -> PathBuf {
    let here = std::path::absolute(spec).unwrap_or_else(|_| spec.to_owned());
    let crate_root = here.ancestors().skip(1).find(|folder| folder.join("Cargo.toml").is_file());
    let own = here.parent().map(Path::to_owned).unwrap_or_default();
    let absolute = crate_root.map(Path::to_owned).or_else(|| root.map(Path::to_owned)).unwrap_or(own);
    // Shorter in messages, and the same folder.
    match std::env::current_dir() {
        Ok(current) => absolute.strip_prefix(current).map(Path::to_owned).unwrap_or(absolute),
        Err(_) => absolute,
    }
}
