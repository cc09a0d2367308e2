//! The specs that a spec lists in `report.compare`, and what makes them unsuitable for comparison.

use std::path::Path;

use super::files::is_suite;
use super::findings::Findings;
use super::plan::plain_arm;
use crate::check::{Checked, Checker, unrunnable};
use crate::diag::{Diagnostic, Severity, Sources, Span};
use crate::escape;
use crate::plan::{PlanError, lower, same_results};
use crate::spec::load::is_unknown_profile;
use crate::spec::section::Report;
use crate::spec::suggest::listed;
use crate::spec::{Experiment, LoadOptions};
use crate::syntax::Files;

/// What is wrong with the comparisons of a spec, which may itself have errors. Warnings about the other specs
/// are reported when those are checked themselves.
pub fn findings(
    spec: &Checked,
    file: &Path,
    options: &LoadOptions,
    files: &dyn Files,
    checker: &mut Checker,
) -> Vec<Findings> {
    let lacks_profile = spec.sink.diagnostics.iter().any(is_unknown_profile);
    let Some(experiment) = spec.experiment.as_ref().filter(|own| !own.is_abstract && !lacks_profile) else {
        return Vec::new();
    };
    let (mut found, mut others, mut seen) = (Vec::new(), Vec::new(), vec![files.identity(file)]);
    for (entry, path) in experiment.compare.iter().enumerate() {
        let identity = files.identity(path);
        // The check of the spec itself reports entries that cannot be read.
        if seen.contains(&identity) || !files.is_file(path) || experiment.reach.refusal(files, path).is_some()
        {
            continue;
        }
        seen.push(identity);
        if let Some(error) = no_suite(path, spec, entry) {
            found.push(Findings::of(spec.sources.clone(), vec![error]).in_file(file));
            continue;
        }
        let options = checker.applicable(files, path, options);
        let other = checker.check(files, path, &options);
        if other.sink.diagnostics.iter().any(is_unknown_profile) {
            let lacking = lacking_profiles(experiment, &other);
            let error = at_entry(without_profiles(path, &lacking), spec, entry);
            found.push(Findings::of(spec.sources.clone(), vec![error]).in_file(file));
        } else if other.sink.has_errors() {
            let told = format!("`{}` compares itself with {}", experiment.name, path.display());
            found.push(errors(other, &told).in_file(path));
        } else if let Some(error) = no_parent(&other, spec, entry) {
            found.push(Findings::of(spec.sources.clone(), vec![error]).in_file(file));
        } else {
            if let Some(error) = same_results(spec, &other, entry) {
                found.push(Findings::of(spec.sources.clone(), vec![error]).in_file(file));
            }
            others.push(other);
        }
    }
    found.extend(namesakes(spec, &others));
    found
}

/// The profiles of a spec that a compared one lacks.
fn lacking_profiles(own: &Experiment, other: &Checked) -> Vec<String> {
    let known = other.experiment.as_ref().map(|other| other.profiles.clone()).unwrap_or_default();
    own.profiles.iter().filter(|name| !known.contains(name)).cloned().collect()
}

/// E0706 for an entry of `report.compare` that lacks profiles of the spec.
pub fn without_profiles(other: &Path, lacking: &[String]) -> Diagnostic {
    /// Most profiles named in the message.
    const NAMED: usize = 5;
    let other = escape::file(other);
    let named = listed(lacking.iter().take(NAMED).map(String::as_str));
    let more = lacking.len().saturating_sub(NAMED);
    let message = match (lacking.len(), more) {
        (1, _) => format!("the compared spec `{other}` has no profile {named}"),
        (_, 0) => format!("the compared spec `{other}` lacks the profiles {named}"),
        _ => format!("the compared spec `{other}` lacks the profiles {named} and {more} more"),
    };
    Diagnostic::error("E0706", message).help(
        "add the profile to that spec, or compare with none: `compare = []` below `[report]` of this spec",
    )
}

/// E0816 for an entry with exactly the spec's own results, by the fingerprints of the stages. Specs with the
/// same name are a separate error.
fn same_results(spec: &Checked, other: &Checked, entry: usize) -> Option<Diagnostic> {
    let [own, compared] = [spec.sound()?.0, other.sound()?.0];
    if same_results::train_other_policies(&own.table, &compared.table) {
        return None;
    }
    let arms = [plain_arm(spec)?, plain_arm(other)?];
    let error = same_results::specs(&lower(&arms, None).ok()?, &arms[0].name, &arms[1].name)?;
    Some(at_entry(error, spec, entry))
}

/// The errors of a spec, with a sentence that names the spec comparing itself with it.
fn errors(other: Checked, sentence: &str) -> Findings {
    let Checked { sources, sink, .. } = other;
    let mut errors = sink.diagnostics;
    errors.retain(|found| found.severity == Severity::Error);
    let mut findings = Findings::of(sources, errors);
    explain(&mut findings, sentence);
    findings
}

/// Adds a sentence to the help of every error.
pub fn explain(findings: &mut Findings, sentence: &str) {
    let errors = findings.diagnostics.iter_mut().filter(|found| found.severity == Severity::Error);
    errors.for_each(|found| found.help.push(sentence.to_owned()));
}

/// One error for each name shared by several specs.
fn namesakes(spec: &Checked, others: &[Checked]) -> Vec<Findings> {
    let specs: Vec<&Checked> = std::iter::once(spec).chain(others).collect();
    let mut names: Vec<&String> =
        specs.iter().filter_map(|spec| spec.experiment.as_ref()).map(|experiment| &experiment.name).collect();
    names.sort();
    let mut twice: Vec<&String> =
        names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    twice.dedup();
    let finding = |name: &String| {
        let error = PlanError::SameName { name: name.clone() };
        let (sources, place) = located(&error, &specs);
        Findings::of(sources, vec![error.diagnostic(place)])
    };
    twice.into_iter().map(finding).collect()
}

/// E0606 for an entry that is a suite.
pub fn no_suite(file: &Path, by: &Checked, entry: usize) -> Option<Diagnostic> {
    is_suite(file).then(|| {
        let message = format!("`{}` is a suite, and a spec is compared with specs", escape::file(file));
        at_entry(
            Diagnostic::error("E0606", message).help("name one of the specs that the suite varies"),
            by,
            entry,
        )
    })
}

/// E0606 for an entry that is only a parent.
pub fn no_parent(other: &Checked, by: &Checked, entry: usize) -> Option<Diagnostic> {
    let reason = other.experiment.as_ref().and_then(|experiment| unrunnable(experiment, &other.sources))?;
    Some(at_entry(Diagnostic { labels: Vec::new(), ..reason }, by, entry))
}

/// A diagnostic at an entry of a spec's `report.compare`.
pub fn at_entry(diagnostic: Diagnostic, by: &Checked, entry: usize) -> Diagnostic {
    let marks = by.experiment.as_ref().map(|experiment| &experiment.marks);
    match marks.and_then(|marks| marks.nearest(&Report::compared(entry))) {
        Some(mark) => diagnostic.at(mark.value, "compared with here"),
        None => diagnostic,
    }
}

/// The sources of the spec that an error of the plan is about, and the position in them. Of specs with the
/// same name, it is the last.
pub fn located(error: &PlanError, specs: &[&Checked]) -> (Sources, Option<Span>) {
    let named = |name: &str| {
        let is_named =
            |spec: &&&Checked| spec.experiment.as_ref().is_some_and(|experiment| experiment.name == name);
        specs.iter().rfind(is_named)
    };
    let found = error.place().and_then(|(name, path)| Some((named(name)?, path)));
    let Some((spec, path)) = found else { return Default::default() };
    let place = spec.experiment.as_ref().and_then(|experiment| match path {
        "name" => Some(name_of(experiment, &spec.sources)),
        _ => experiment.marks.nearest(path).map(|mark| mark.key),
    });
    (spec.sources.clone(), place)
}

/// Where a spec's name is written; the start of the file if it is named after the file.
fn name_of(experiment: &Experiment, sources: &Sources) -> Span {
    let written = format!("\"{}\"", experiment.name);
    let (source, found) = (experiment.source, sources.get(experiment.source).text.find(&written));
    found.map_or(Span { source, start: 0, end: 0 }, |start| Span {
        source,
        start,
        end: start + written.len(),
    })
}
