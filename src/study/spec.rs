//! Specs and the specs that they compare themselves with, checked and lowered to one plan.

use std::path::{Path, PathBuf};

use super::compared;
use super::files::{identity, is_suite};
use super::findings::{Findings, Log};
use super::plan::{Reported, lowered, plain_arm, project, request};
use super::{Refusal, Study};
use crate::check::{self, Checked, Checker, unrunnable};
use crate::escape::shell;
use crate::plan::{Arm, PlanError, same_results};
use crate::spec::load::is_unknown_profile;
use crate::spec::{Experiment, LoadOptions, Table};
use crate::syntax::Disk;

/// Loads and checks one spec; `Err` if it has errors. Its diagnostics are in the log and in the spec.
pub fn checked(path: &Path, options: &LoadOptions, log: &mut Log) -> Result<Checked, Refusal> {
    if is_suite(path) {
        return Err(Refusal::Usage {
            message: format!("{} is a suite, and this takes a single spec", path.display()),
            advice: "name a spec; `specforge show SUITE --arm ARM` shows one arm of a suite".to_owned(),
        });
    }
    let checked = check::checked(path, options);
    log.add(Findings::of(checked.sources.clone(), checked.sink.diagnostics.clone()).in_file(path))?;
    if checked.experiment.is_none() { Err(Refusal::Invalid) } else { Ok(checked) }
}

/// An entry of a spec's `report.compare`.
struct Entry {
    /// Index of the spec with the entry.
    by: usize,
    /// Index in its list.
    place: usize,
    /// Index of the spec that the entry names.
    other: usize,
}

/// The plan of specs.
pub fn read(files: &[PathBuf], options: &LoadOptions, log: &mut Log) -> Result<Study, Refusal> {
    let mut specs: Vec<Checked> = Vec::new();
    let mut arms: Vec<Arm> = Vec::new();
    // Each file with the spec that lists it for comparison, and the index in its list.
    let mut open: Vec<(PathBuf, Option<(usize, usize)>)> =
        files.iter().map(|file| (file.clone(), None)).collect();
    let mut seen = Vec::new();
    let mut place = None;
    // The specs that are only compared with, and the entries that name them.
    let mut entries: Vec<Entry> = Vec::new();
    while !open.is_empty() {
        let (file, named) = open.remove(0);
        let identity = identity(&file);
        if seen.contains(&identity) {
            continue;
        }
        seen.push(identity);
        let by = named.map(|(spec, entry)| (&specs[spec], entry));
        let own = match by {
            Some(_) if !is_suite(&file) => Checker::default().applicable(&Disk, &file, options),
            _ => options.clone(),
        };
        let checked = comparable(&file, by, &own, log)?;
        let Some((experiment, _)) = checked.sound() else { return Err(Refusal::Invalid) };
        if let Some((by, _)) = by {
            log.notes.extend(unreached(by, experiment, options, &own));
        }
        if named.is_none() {
            // The comparisons of a spec that is only compared with are ignored.
            let compared = experiment.compare.iter().enumerate();
            open.extend(compared.map(|(entry, path)| (path.clone(), Some((specs.len(), entry)))));
        }
        entries.extend(named.map(|(by, place)| Entry { by, place, other: specs.len() }));
        place.get_or_insert_with(|| project(&file, experiment.root.as_deref()));
        arms.push(arm(&checked, &file, place.as_deref(), &own)?);
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
    let study = lowered(&arms, reported, project, located, log)?;
    let same = |Entry { by, place, other }: &Entry| {
        let error = same_results::specs(&study.plan, &arms[*by].name, &arms[*other].name)?;
        Some(Findings::of(specs[*by].sources.clone(), vec![compared::at_entry(error, &specs[*by], *place)]))
    };
    let same: Vec<Findings> = entries.iter().filter_map(same).collect();
    same.into_iter().try_for_each(|found| log.add(found))?;
    let first = specs.into_iter().find_map(|spec| spec.experiment);
    let profiles = first.map(|experiment| experiment.profiles.to_vec()).unwrap_or_default();
    Ok(Study { profiles, ..study })
}

/// Says which assignments do not reach a compared spec.
fn unreached(by: &Checked, other: &Experiment, options: &LoadOptions, taken: &LoadOptions) -> Option<String> {
    let lacking = options.sets.iter().filter(|set| !taken.sets.contains(set));
    let word = |set: &String| format!("`--set {}`", shell::argument(Path::new(set)));
    let lacking: Vec<String> = lacking.map(word).collect();
    let own = &by.experiment.as_ref()?.name;
    (!lacking.is_empty()).then(|| {
        let [sets, other] = [lacking.join(" and "), other.name.clone()];
        format!(
            "{sets} reaches `{own}` and not `{other}`, which it is compared with and which lacks this key"
        )
    })
}

/// Most bytes of a report's name: file systems allow 255, and extensions are added.
const LONGEST: usize = 120;

/// The name of a report on several specs: `A_vs_B`, or if too long, the first one with a digest of all.
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

/// A checked spec that can be run. Errors of a spec in `report.compare` mention the entry.
fn comparable(
    file: &Path,
    by: Option<(&Checked, usize)>,
    options: &LoadOptions,
    log: &mut Log,
) -> Result<Checked, Refusal> {
    if let Some((by, entry)) = by
        && let Some(error) = compared::no_suite(file, by, entry)
    {
        log.add(Findings::of(by.sources.clone(), vec![error]).in_file(file))?;
    }
    let known = log.findings.len();
    let checked = checked(file, options, log).inspect_err(|_| {
        let Some((by, entry)) = by else { return };
        let lacks =
            log.findings[known..].iter().any(|found| found.diagnostics.iter().any(is_unknown_profile));
        if let Some(profile) = options.profile.clone().filter(|_| lacks) {
            let error = compared::at_entry(compared::without_profiles(file, &[profile]), by, entry);
            log.findings.truncate(known);
            log.findings.push(Findings::of(by.sources.clone(), vec![error]).in_file(file));
            return;
        }
        let Some(experiment) = by.experiment.as_ref() else { return };
        let chosen = options.profile.as_ref().map(|profile| format!(" with `--profile {profile}`"));
        let chosen = chosen.unwrap_or_default();
        let told = format!("`{}` compares itself with {}{chosen}", experiment.name, file.display());
        log.findings[known..].iter_mut().for_each(|findings| compared::explain(findings, &told));
    })?;
    // A parent may be incomplete, so the error is only that it cannot be run.
    let (sources, reason) = match by {
        Some((by, entry)) => (&by.sources, compared::no_parent(&checked, by, entry)),
        None => {
            let experiment = checked.experiment.as_ref();
            (&checked.sources, experiment.and_then(|experiment| unrunnable(experiment, &checked.sources)))
        }
    };
    if let Some(reason) = reason {
        log.add(Findings::of(sources.clone(), vec![reason]).in_file(file))?;
    }
    Ok(checked)
}

/// An arm of a checked spec, with its request.
fn arm(
    checked: &Checked,
    file: &Path,
    project: Option<&Path>,
    options: &LoadOptions,
) -> Result<Arm, Refusal> {
    let request = request(file, project.unwrap_or(Path::new(".")), options);
    Ok(Arm { request, ..plain_arm(checked).ok_or(Refusal::Invalid)? })
}
