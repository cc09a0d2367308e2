//! From the arguments of `plan`, `run` and `why` to a plan: every spec and the specs that it compares
//! itself with, checked and lowered; a suite; or a plan from a file.

use std::path::{Path, PathBuf};

use super::comparison::{Comparison, Reported, lowered, place_in, project};
use super::specs::{self, Findings, Told, Variant};
use super::{Exit, Global, compared, output, suites, walk};
use crate::bounded;
use crate::check::{Checked, unrunnable};
use crate::diag::{Diagnostic, Sources};
use crate::escape;
use crate::plan::{Arm, Plan, PlanError, Request, SavedError, Shared, same_results};
use crate::spec::Table;

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
        [file] if is_plan(file) && source.variant.varies() => {
            let message = format!("`--profile` and `--set` vary a spec, and {} is a plan", file.display());
            let advice =
                "name them when the plan is written: `specforge plan SPEC --profile NAME --save PLAN.json`";
            output::complain(global, &message, Some(advice));
            Err(Exit::Usage)
        }
        [file] if is_plan(file) => saved(file, global),
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

fn is_plan(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "json")
}

/// A plan from a file.
pub fn saved(file: &Path, global: &Global) -> Result<Comparison, Exit> {
    let text = match bounded::text(file, bounded::RECORD) {
        Err(error) if error.is_absence() => {
            let advice = "write a plan with `specforge plan SPEC --save PLAN.json`";
            let missing =
                Diagnostic::error("E0004", format!("file not found: `{}`", escape::file(file))).help(advice);
            specs::tell(&[Findings::of(Sources::default(), vec![missing]).in_file(file)], global);
            return Err(Exit::Invalid);
        }
        text => text.map_err(|error| error.to_string()),
    };
    let plan = text.map(|text| Plan::from_json(&text));
    match plan {
        Ok(Ok(plan)) => {
            let report = plan.stages().find(|stage| stage.kind == crate::plan::StageKind::Report);
            let name = report.map_or("report", |stage| stage.users[0].arm.as_str()).to_owned();
            let spec = plan.arms.first().map(|arm| PathBuf::from(&arm.request.spec)).unwrap_or_default();
            Ok(Comparison { plan, name, project: project(&spec, None), profiles: Vec::new() })
        }
        Ok(Err(SavedError::Plan(error))) => {
            specs::tell(
                &[Findings::of(Sources::default(), vec![error.diagnostic(None)]).in_file(file)],
                global,
            );
            Err(Exit::Invalid)
        }
        Ok(Err(error @ SavedError::Format(_))) => Err(no_plan(file, &error.to_string(), global)),
        Err(reason) => Err(no_plan(file, &reason, global)),
    }
}

fn no_plan(file: &Path, reason: &str, global: &Global) -> Exit {
    let advice = Some("write the plan with `specforge plan SPEC --save PLAN.json`");
    output::complain(global, &format!("{}: {reason}", file.display()), advice);
    Exit::Usage
}

/// An entry of a spec's `report.compare`.
struct Entry {
    /// The spec that has it, by its place among all.
    by: usize,
    /// Its place in the list.
    place: usize,
    /// The spec that it names, likewise.
    other: usize,
}

fn from_specs(files: &[PathBuf], variant: &Variant, global: &Global) -> Result<Comparison, Exit> {
    let mut specs: Vec<Checked> = Vec::new();
    let mut arms: Vec<Arm> = Vec::new();
    // With the spec that compares itself with the file, and which entry of its list that is.
    let mut open: Vec<(PathBuf, Option<(usize, usize)>)> =
        files.iter().map(|file| (file.clone(), None)).collect();
    let (mut seen, mut told) = (Vec::new(), Told::default());
    let mut place = None;
    // The specs that were only compared with, and the entries that name them.
    let mut entries: Vec<Entry> = Vec::new();
    while !open.is_empty() {
        let (file, named) = open.remove(0);
        let identity = walk::identity(&file);
        if seen.contains(&identity) {
            continue;
        }
        seen.push(identity);
        let by = named.map(|(spec, entry)| (&specs[spec], entry));
        let checked = comparable(&file, by, variant, &mut told, global)?;
        let Some((experiment, _)) = checked.sound() else { return Err(Exit::Invalid) };
        if named.is_none() {
            // A spec that is only compared with does not bring its own comparisons.
            let compared = experiment.compare.iter().enumerate();
            open.extend(compared.map(|(entry, path)| (path.clone(), Some((specs.len(), entry)))));
        }
        entries.extend(named.map(|(by, place)| Entry { by, place, other: specs.len() }));
        place.get_or_insert_with(|| project(&file, experiment.root.as_deref()));
        arms.push(arm(&checked, &file, place.as_deref(), variant)?);
        specs.push(checked);
    }
    let project = place.unwrap_or_default();
    let named = &arms[..files.len().min(arms.len())];
    let name = joined(named);
    let located = |error: &PlanError| compared::located(error, &specs.iter().collect::<Vec<_>>());
    let mut baselines: Vec<Table> = Vec::new();
    for baseline in specs.iter().flat_map(|spec| &spec.baselines) {
        if !baselines.contains(baseline) {
            baselines.push(baseline.clone());
        }
    }
    let reported = Reported { name: &name, suite: None, baselines };
    let comparison = lowered(&arms, reported, project, located, global)?;
    let same = |Entry { by, place, other }: &Entry| {
        let error = same_results::specs(&comparison.plan, &arms[*by].name, &arms[*other].name)?;
        Some(Findings::of(specs[*by].sources.clone(), vec![compared::at_entry(error, (&specs[*by], *place))]))
    };
    if specs::tell(&entries.iter().filter_map(same).collect::<Vec<_>>(), global) {
        return Err(Exit::Invalid);
    }
    let first = specs.into_iter().find_map(|spec| spec.experiment);
    Ok(Comparison {
        profiles: first.map(|experiment| experiment.profiles.to_vec()).unwrap_or_default(),
        ..comparison
    })
}

/// Bytes of a report's name at most: file systems take 255, and endings are added.
const LONGEST: usize = 120;

/// The name of a report on several specs: `A_vs_B`, or of many the first one with a digest of all.
fn joined(arms: &[Arm]) -> String {
    let name = arms.iter().map(|arm| arm.name.as_str()).collect::<Vec<_>>().join("_vs_");
    match arms {
        [first, rest @ ..] if name.len() > LONGEST && !rest.is_empty() => {
            let digest = blake3::hash(name.as_bytes()).to_hex();
            format!("{}_vs_{}_others_{}", first.name, rest.len(), &digest[..8])
        }
        _ => name,
    }
}

/// A checked spec that can be run. What keeps a spec of `report.compare` from it is told with the place that
/// names it.
fn comparable(
    file: &Path,
    by: Option<(&Checked, usize)>,
    variant: &Variant,
    told: &mut Told,
    global: &Global,
) -> Result<Checked, Exit> {
    let tell = |sources: &Sources, diagnostic: Diagnostic| {
        specs::tell(&[Findings::of(sources.clone(), vec![diagnostic]).in_file(file)], global);
        Exit::Invalid
    };
    if let Some((by, entry)) = by
        && let Some(error) = compared::no_suite(file, (by, entry))
    {
        return Err(tell(&by.sources, error));
    }
    let checked = specs::require_among(file, variant, told, global).inspect_err(|_| {
        if let Some(name) = by.and_then(|(by, _)| by.experiment.as_ref()).map(|experiment| &experiment.name) {
            let chosen = variant
                .profile
                .as_ref()
                .map(|profile| format!(" with `--profile {profile}`"))
                .unwrap_or_default();
            let message = format!("`{name}` compares itself with {}{chosen}", file.display());
            output::note(global, &message);
        }
    })?;
    // A parent may be incomplete; what is wrong with running it is that it is one.
    let (sources, reason) = match by {
        Some(by) => (&by.0.sources, compared::no_parent(&checked, by)),
        None => {
            let experiment = checked.experiment.as_ref();
            (&checked.sources, experiment.and_then(|experiment| unrunnable(experiment, &checked.sources)))
        }
    };
    match reason {
        Some(reason) => Err(tell(sources, reason)),
        None => Ok(checked),
    }
}

/// An arm of a checked spec with what was asked for.
fn arm(checked: &Checked, file: &Path, project: Option<&Path>, variant: &Variant) -> Result<Arm, Exit> {
    let request = Request {
        spec: file.display().to_string(),
        place: place_in(project.unwrap_or(Path::new(".")), file),
        profile: variant.profile.clone(),
        assignments: variant.sets.clone(),
        outside: variant.allow_outside.iter().map(|folder| folder.display().to_string()).collect(),
    };
    Ok(Arm { request, ..plain_arm(checked).ok_or(Exit::Invalid)? })
}

/// An arm of a checked spec; `None` when that has errors.
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
