//! The name of a report: that of its spec, unless the page with that name is of something else.
//!
//! A page belongs to a spec, profile, assignments and budget. Any other report is named `NAME.PROFILE.md`, or
//! `NAME.PROFILE.DIGEST.md` if a `--set` or the spec differs. Another commit, or an edited spec, updates the
//! same page.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{Study, origins};
use crate::plan::{Plan, PlanError};
use crate::report::claim;
use crate::report::gather::request;
use crate::report::index;
use crate::report::request::Request;
use crate::report::sidecar::{ArmRecord, Sidecar};
use crate::report::table::setup::budget_of;
use crate::report::{fields, wording};
use crate::spec::Claim;

/// The profile in the page name of a run without one.
const NO_PROFILE: &str = "full";

/// Most names that are tried for a report whose own is taken.
const MOST_NAMES: u32 = 100;

/// Most bytes of a profile in a page name; the digest covers the rest.
const LONGEST_PROFILE: usize = 60;

/// The destination of a report.
#[derive(Clone, Copy, Debug)]
pub struct Destination<'a> {
    /// The folder of reports.
    pub folder: &'a Path,
    /// The name of the spec, which the report uses unless it is taken.
    pub own: &'a str,
}

/// Why the name of the spec is taken.
enum Taken {
    /// The page with that name is of another spec.
    Spec(String),
    /// It is of something else.
    Other(String),
}

/// The name of a report's page.
#[derive(Debug)]
pub struct Choice {
    /// The name, without `.md`.
    pub name: String,
    /// Why it differs from the spec's, for the user.
    pub note: Option<String>,
}

/// A study whose report has an available page name.
pub struct Settled {
    /// The study.
    pub study: Study,
    /// The name of the spec.
    pub own: String,
    /// Why the page's name differs from the spec's, for the user.
    pub note: Option<String>,
}

/// Names the study's report by the pages that exist in a folder.
pub fn settled(study: Study, folder: &Path) -> Result<Settled, PlanError> {
    let own = study.name.clone();
    let Choice { name, note } = choice(&study, Destination { folder, own: &own });
    if name == own {
        return Ok(Settled { study, own, note });
    }
    let plan = study.plan.reported_as(&name)?;
    Ok(Settled { study: Study { plan, name, ..study }, own, note })
}

/// Chooses the page name of a study by the pages that exist in a folder.
pub fn choice(study: &Study, destination: Destination) -> Choice {
    let Destination { folder, own } = destination;
    let (is_other_spec, reason) = match taken(study, folder, own) {
        None => return Choice { name: own.to_owned(), note: None },
        Some(Taken::Spec(reason)) => (true, reason),
        Some(Taken::Other(reason)) => (false, reason),
    };
    let request = request(&study.plan);
    let profile = request.profile.as_deref().unwrap_or(NO_PROFILE);
    let plain = profile.replace(|c: char| !c.is_alphanumeric() && c != '-', "_");
    let short: String =
        plain.char_indices().take_while(|(at, _)| *at < LONGEST_PROFILE).map(|(_, c)| c).collect();
    let beside = format!("{own}.{short}");
    let is_plain = !is_other_spec && request.set.is_empty() && short == plain;
    let name = match is_plain && taken(study, folder, &beside).is_none() {
        true => beside,
        false => {
            let numbered = |number| format!("{beside}.{}", digest(&study.plan, &request, number));
            let mut names = (0..MOST_NAMES).map(numbered);
            names.find(|name| taken(study, folder, name).is_none()).unwrap_or_else(|| numbered(MOST_NAMES))
        }
    };
    let page = |name: &str| folder.join(format!("{name}.md")).display().to_string();
    let note = format!("{} {reason}, so this report is {}", page(own), page(&name));
    Choice { name, note: Some(note) }
}

/// Why a report of this study cannot have this name; `None` if the page does not exist or is of the same run.
fn taken(study: &Study, folder: &Path, name: &str) -> Option<Taken> {
    let other = |reason: &str| Some(Taken::Other(reason.to_owned()));
    if index::FILE.eq_ignore_ascii_case(&format!("{name}.md")) {
        return other("is the index of all reports");
    }
    let page = folder.join(format!("{name}.md"));
    match Sidecar::read(&Sidecar::path(folder, name)) {
        Ok(_) if origins::is_of_another(folder, name, &study.project) => {
            Some(Taken::Spec("is of a spec in another project".to_owned()))
        }
        Ok(record) => difference(&record, study),
        Err(error) if error.is_absence() && page.symlink_metadata().is_err() => None,
        Err(error) if error.is_absence() => other("has no record that says what it is of"),
        Err(_) => other("has a record that cannot be read"),
    }
}

/// What distinguishes the run of a record from that of a study.
fn difference(record: &Sidecar, study: &Study) -> Option<Taken> {
    let plan = &study.plan;
    let (recorded, present) = (&record.request, request(plan));
    let other = |reason: String| Some(Taken::Other(reason));
    if recorded.is_empty() {
        return other("does not say which specs it is of".to_owned());
    }
    if !is_same_spec(record, study) {
        return Some(Taken::Spec(format!("is of another spec ({})", recorded.files.join(", "))));
    }
    if recorded.profile != present.profile {
        return other(match &recorded.profile {
            Some(profile) => format!("is of the profile `{profile}`"),
            None => "is of no profile".to_owned(),
        });
    }
    let sorted = |sets: &[String]| sets.iter().cloned().collect::<BTreeSet<String>>();
    if sorted(&recorded.set) != sorted(&present.set) {
        return other(match recorded.set.as_slice() {
            [] => "is of the spec without `--set`".to_owned(),
            sets => format!("is of `--set {}`", sets.join(" --set ")),
        });
    }
    match record.facts.budgets == budgets_of(plan) {
        true => None,
        false => other(format!("is of another budget ({} samples)", budget_words(record))),
    }
}

/// Whether a record has the same spec files as a study, or specs with the same values.
fn is_same_spec(record: &Sidecar, study: &Study) -> bool {
    let plan = &study.plan;
    let (recorded, present) = (&record.request, request(plan));
    let pairs = || recorded.files.iter().map(Path::new).zip(present.files.iter().map(Path::new));
    let others = pairs().any(|(recorded, present)| are_two_files(recorded, present, &study.project));
    if others || recorded.files.len() != present.files.len() {
        return false;
    }
    let same_places = recorded.specs == present.specs;
    // A spec that was moved; a suite with other claims is another one.
    same_places || has_same_values(record, plan) && has_same_claims(record, plan)
}

/// Whether two paths, relative to the project or the current folder, are the same file.
fn is_same_file(recorded: &Path, present: &Path, project: &Path) -> bool {
    recorded == present || !real(recorded, project).is_disjoint(&real(present, project))
}

/// Whether both files exist and are different ones. Two projects may have a spec at the same place in each.
fn are_two_files(recorded: &Path, present: &Path, project: &Path) -> bool {
    let exist = [recorded, present].iter().all(|path| !real(path, project).is_empty());
    exist && !is_same_file(recorded, present, project)
}

/// The files that a path may name, relative to the project or the current folder.
fn real(path: &Path, project: &Path) -> BTreeSet<PathBuf> {
    [project.join(path), path.to_owned()].iter().filter_map(|path| path.canonicalize().ok()).collect()
}

/// Whether a record has judged the claims of a plan.
fn has_same_claims(record: &Sidecar, plan: &Plan) -> bool {
    let claims = plan.suite.as_ref().map_or(&[][..], |suite| suite.claims.as_slice());
    let is_judged = |claim: &Claim| record.claims.iter().any(|judged| claim::is_of(judged, claim));
    record.claims.len() == claims.len() && claims.iter().all(is_judged)
}

/// Whether all arms of a record have the same values as those of a plan.
fn has_same_values(record: &Sidecar, plan: &Plan) -> bool {
    let same = |(recorded, present): (&ArmRecord, &crate::plan::graph::ArmRecord)| {
        let values =
            record.fields(recorded).into_iter().map(|(path, field)| (path.clone(), field.value.clone()));
        let table = present.fields.table();
        let own = fields::flat(&table).into_iter().map(|(path, value)| (path, wording::value(value)));
        recorded.name == present.name && values.collect::<BTreeSet<_>>() == own.collect::<BTreeSet<_>>()
    };
    record.arms.len() == plan.arms.len() && record.arms.iter().zip(&plan.arms).all(same)
}

fn budgets_of(plan: &Plan) -> Vec<u64> {
    let budgets: BTreeSet<u64> =
        plan.arms.iter().filter_map(|arm| budget_of(&arm.fields.only(&["learn", "fine_tune"]))).collect();
    budgets.into_iter().collect()
}

/// `300 k`; `no` for runs without training.
fn budget_words(record: &Sidecar) -> String {
    let counts: Vec<String> = record.facts.budgets.iter().copied().map(wording::count).collect();
    if counts.is_empty() { "no".to_owned() } else { counts.join(", ") }
}

/// Eight digits that identify a report's specs and options; the same for the same command. A number above 0
/// gives other digits, for when those are taken.
fn digest(plan: &Plan, request: &Request, number: u32) -> String {
    let mut hasher = blake3::Hasher::new();
    for place in &request.specs {
        hasher.update(place.as_bytes()).update(&[0]);
    }
    hasher.update(format!("{:?}{:?}{:?}", request.profile, request.set, budgets_of(plan)).as_bytes());
    if number > 0 {
        hasher.update(&number.to_le_bytes());
    }
    hasher.finalize().to_hex()[..8].to_owned()
}
