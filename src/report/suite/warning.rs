//! Warnings in a suite's report.

use std::collections::BTreeMap;

use super::{interval, tried};
use crate::report::group::{Group, groups};
use crate::report::model::ReportInput;
use crate::report::table::health::shown;
use crate::report::table::setup::{budget_samples, trained_samples};
use crate::report::verdict::stands_still;
use crate::report::wording::{arm_in_words, count, number};
use crate::report::{crossing, rates, untrained};

/// Most runs that are listed by name.
const NAMED: usize = 8;

/// The warnings, most serious first.
pub fn warnings(input: &ReportInput) -> Vec<String> {
    let groups = groups(input);
    let mut warnings = failures(input);
    warnings.extend(groups.iter().flat_map(explosions));
    warnings.extend(groups.iter().filter_map(standing_still));
    warnings.extend(groups.iter().filter_map(never_updated));
    warnings.extend(unwell(&groups));
    warnings.extend(crossing::warnings(&input.arms.iter().collect::<Vec<_>>()));
    warnings.extend(rates::warning(&input.arms));
    warnings.push(seeds(&groups));
    warnings.extend(budgets(&groups));
    warnings.extend(tried::warning(&groups));
    warnings
}

/// Runs with missing results, the first of them by name.
fn failures(input: &ReportInput) -> Vec<String> {
    let failed: Vec<String> = input
        .arms
        .iter()
        .filter_map(|arm| {
            let failure = arm.failures.first()?;
            // The scheduler prefixes the stages of single runs with the run's name.
            let stage = failure.stage.strip_prefix(&format!("{}/", arm.name)).unwrap_or(&failure.stage);
            Some(format!("{}: stage `{stage}` has no result: {}.", arm_in_words(&arm.name), failure.reason))
        })
        .collect();
    let rest = failed.len().saturating_sub(NAMED);
    let rest = (rest > 0).then(|| format!("{rest} more runs have not all their results."));
    failed.into_iter().take(NAMED).chain(rest).collect()
}

/// Stages of an arm in which the simulation diverged (NaN or infinity) in some episodes.
fn explosions(group: &Group<'_>) -> Vec<String> {
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for measured in group.runs.iter().flat_map(|run| &run.evaluations) {
        let [exploded, all] = counts.entry(&measured.stage).or_default();
        *exploded += measured.evaluation.diverged().count();
        *all += measured.evaluation.episodes.len();
    }
    let told =
        counts.into_iter().filter(|(_, [exploded, _])| *exploded > 0).map(|(stage, [exploded, all])| {
            format!(
                "{}, `{stage}`: the physics diverged in {exploded} of {all} episodes; their \
             speeds, forces and torques \
             mean nothing.",
                arm_in_words(group.name)
            )
        });
    told.collect()
}

fn standing_still(group: &Group<'_>) -> Option<String> {
    let moving = |run: &&&crate::report::model::Arm| run.travels();
    let still = |run: &&&crate::report::model::Arm| {
        run.evaluations.first().is_some_and(|one| stands_still(&one.evaluation))
    };
    let count = group.runs.iter().filter(moving).filter(still).count();
    (count > 0).then(|| {
        format!(
            "{}: {count} of {} policies survive by standing still; that is not the task.",
            arm_in_words(group.name),
            group.runs.len()
        )
    })
}

/// W0508: the trainings of an arm that never updated the actor.
fn never_updated(group: &Group<'_>) -> Option<String> {
    let runs = || group.runs.iter().filter(|run| untrained::is_untrained(run));
    let first = runs().next()?;
    Some(format!(
        "{}: {} of {} trainings never updated the actor (`W0508`), {}: the policy is {}.",
        arm_in_words(group.name),
        runs().count(),
        group.runs.len(),
        untrained::cause(first),
        untrained::network(first)
    ))
}

fn unwell(groups: &[Group<'_>]) -> Option<String> {
    let runs = || groups.iter().flat_map(|group| &group.runs);
    let count = runs().filter(|run| shown(run).next().is_some()).count();
    (count > 0).then(|| {
        format!("The run-time checks warn in {count} of {} trainings, see Learning.", runs().count())
    })
}

fn seeds(groups: &[Group<'_>]) -> String {
    let count = interval::fewest(groups);
    match (count, interval::of_few(count)) {
        (0 | 1, _) => "Only one seed per arm: a difference between arms may be chance.".to_owned(),
        (_, Some(words)) => format!(
            "{count} seeds per arm: a bootstrap interval over them is {words}; see the individual curves."
        ),
        (_, None) => format!(
            "{count} seeds per arm; intervals are over seeds, so they are about the arms, not about single \
             policies."
        ),
    }
}

fn budgets(groups: &[Group<'_>]) -> Vec<String> {
    let mut budgets: Vec<u64> =
        groups.iter().filter_map(|group| budget_samples(group.runs.first()?)).collect();
    budgets.sort_unstable();
    let (Some(least), Some(most)) = (budgets.first(), budgets.last()) else { return Vec::new() };
    let mut found = Vec::new();
    let shares = groups.iter().filter_map(|group| group.runs.first()?.budget_share);
    if let Some(share) = shares.min_by(f64::total_cmp).filter(|share| *share < 1.0) {
        let run = if least == most { "per run" } else { "per run of the arm that has least" };
        let (samples, scale) = (count(*least), number(100.0 * share));
        found.push(format!("The budget is below the baseline's: {samples} samples {run}, {scale} %."));
    }
    if least != most {
        found.push(format!(
            "The arms have different budgets ({} to {} samples): compare only arms of one budget.",
            count(*least),
            count(*most)
        ));
    } else {
        let taken = groups.iter().filter_map(|group| trained_samples(group.runs.first()?));
        let (fewest, most) =
            taken.fold((u64::MAX, 0), |(low, high), taken| (low.min(taken), high.max(taken)));
        if fewest < most {
            found.push(format!(
                "Trainings end after whole updates, so the arms have between {fewest} and {most} samples: their \
                 rollouts differ."
            ));
        }
    }
    found
}
