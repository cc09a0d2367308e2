//! How many more runs or episodes would settle an open claim, from the observed variance.

use super::{Case, Evidence, Judged, Ruling};
use crate::kinds::statistic::{self, Method};
use crate::statistics::difference::Pairs;
use crate::statistics::power::{
    alike_runs_needed, episodes_needed, observations_needed, ranks_needed, runs_needed, times_needed,
};
use crate::statistics::proportion::score_test;
use crate::statistics::summary::deviation;
use crate::statistics::{mean, rank, trend};

/// What would settle an open comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needed {
    /// Runs per arm, or episodes per policy.
    Number(usize),
    /// More than can be run: the estimate lies on the boundary or too close to it.
    TooMany,
    /// Cannot be estimated, for this reason.
    NotEstimated(&'static str),
}

impl From<Option<usize>> for Needed {
    fn from(number: Option<usize>) -> Self {
        number.map_or(Self::TooMany, Self::Number)
    }
}

/// The reason when an arm has a single run.
const NO_SPREAD: Needed = Needed::NotEstimated("a single run has no spread");

/// How many runs per arm or episodes would settle a claim that is corrected together with `claims` claims.
/// `None` for a claim that is settled, that lacks runs, or whose robots fail their task.
pub fn settled_by(claim: &Judged, claims: usize) -> Option<String> {
    if claim.verdict != Ruling::NotEstablished || !claim.missing.is_empty() {
        return None;
    }
    let level = claim.alpha / claims.max(1) as f64;
    let is_open = |case: &&Case| case.verdict == Ruling::NotEstablished;
    let mut open: Vec<&Case> = claim.cases.iter().filter(is_open).collect();
    if open.is_empty() {
        // Only the correction leaves the claim open.
        open.extend(&claim.cases);
    }
    let needed: Vec<Needed> = open.into_iter().map(|case| needed(claim, case, level)).collect();
    let unit = if claim.unit == "run" { "seeds" } else { "episodes" };
    let corrected = if claims > 1 { format!(", corrected for {claims} claims") } else { String::new() };
    if needed.contains(&Needed::TooMany) {
        return Some(format!("no number of {unit} that can be run settles it at the observed estimate"));
    }
    let reason = needed.iter().find_map(|needed| match needed {
        Needed::NotEstimated(reason) => Some(*reason),
        _ => None,
    });
    let most = needed.iter().filter_map(|needed| match needed {
        Needed::Number(number) => Some(*number),
        _ => None,
    });
    Some(match (reason, most.max(), unit) {
        (Some(reason), ..) => format!("how many {unit} would settle it is not estimated: {reason}"),
        (None, None, _) => format!("how many {unit} would settle it is not estimated: nothing was compared"),
        (None, Some(runs), "seeds") => {
            format!(
                "about {runs} seeds per arm settle it (80 % power at the observed estimate and \
                 spread{corrected})"
            )
        }
        (None, Some(episodes), _) if claim.test == "wilson" => {
            format!("about {episodes} episodes settle it at the observed share{corrected}")
        }
        (None, Some(episodes), _) => format!(
            "about {episodes} episodes per policy settle it (80 % power at the observed estimate and spread \
             between episodes{corrected})"
        ),
    })
}

fn needed(claim: &Judged, case: &Case, level: f64) -> Needed {
    let (Some(value), Some(evidence)) = (case.estimate.value, &case.evidence) else {
        return Needed::NotEstimated("there is no estimate");
    };
    // The nearest boundary is the hardest to distinguish from the estimate.
    let ends = claim.bounds.iter().flatten().copied();
    let Some(nearest) = ends.min_by(|a, b| (value - a).abs().total_cmp(&(value - b).abs())) else {
        return Needed::NotEstimated("its boundary is not recorded");
    };
    let distance = (value - nearest).abs();
    match evidence {
        Evidence::Runs { values, .. } => {
            match statistic::find(&claim.test).map(|test| (test.method, test.least)) {
                Some((Method::MannWhitney | Method::ProbabilityOfImprovement, least)) => {
                    // A probability of improvement is tested against that of equal arms.
                    let shift = if claim.test == "mann_whitney" { nearest } else { 0.0 };
                    by_rank(values, claim.factor, shift, least(level), level)
                }
                _ => by_mean(values, claim, distance, level),
            }
        }
        Evidence::Counts(counts) => match counts.as_slice() {
            [[successes, trials]] => by_share(*successes, *trials, nearest, level),
            _ => by_shares(counts, claim.over.starts_with("trend"), distance, level),
        },
        Evidence::Pairs([both, only_first, only_second, neither]) => {
            let pairs =
                Pairs { both: *both, only_first: *only_first, only_second: *only_second, neither: *neither };
            by_pairs(pairs, nearest, distance, level)
        }
        Evidence::Episodes { values, paired } => by_episodes(values, *paired, claim.factor, distance, level),
    }
}

/// For means of runs, from the spread between the runs of each arm.
fn by_mean(values: &[Vec<Vec<Option<f64>>>], claim: &Judged, distance: f64, level: f64) -> Needed {
    let of_side = |(side, strata): (usize, &Vec<Vec<Option<f64>>>)| {
        let factor = if side == 0 { 1.0 } else { claim.factor };
        let weights = match claim.over.starts_with("trend") {
            true => trend::weights(strata.len()),
            false => vec![1.0 / strata.len() as f64; strata.len()],
        };
        let spread = |(weight, runs): (f64, &Vec<Option<f64>>)| {
            let runs: Vec<f64> = runs.iter().copied().collect::<Option<_>>()?;
            deviation(&runs).map(|deviation| (factor * weight * deviation).abs())
        };
        weights.into_iter().zip(strata).map(spread).collect::<Vec<Option<f64>>>()
    };
    let Some(spreads) = values.iter().enumerate().flat_map(of_side).collect::<Option<Vec<f64>>>() else {
        return NO_SPREAD;
    };
    if distance == 0.0 {
        return Needed::TooMany;
    }
    match spreads.iter().all(|spread| *spread == 0.0) {
        true => alike_runs_needed(level).into(),
        false => runs_needed(distance, &spreads, level).into(),
    }
}

/// For ranks of runs, from how often one arm is ahead; a run that never reached the threshold ranks last.
fn by_rank(values: &[Vec<Vec<Option<f64>>>], factor: f64, shift: f64, least: usize, level: f64) -> Needed {
    let side = |at: usize, moved: &dyn Fn(f64) -> f64| -> Vec<f64> {
        values[at].iter().flatten().map(|run| run.map_or(f64::INFINITY, moved)).collect()
    };
    if values.len() != 2 {
        return Needed::NotEstimated("two arms are needed");
    }
    let (first, second) = (side(0, &|run| run - shift), side(1, &|run| run * factor));
    rank::improvement(&first, &second).map_or(Needed::NotEstimated("an arm has no runs"), |chance| {
        ranks_needed(chance, least, level).into()
    })
}

/// For a single share of successes, assuming that it stays the same.
fn by_share(successes: u64, trials: u64, nearest: f64, level: f64) -> Needed {
    if trials == 0 {
        return Needed::NotEstimated("there are no episodes");
    }
    if score_test(successes, trials, nearest).is_none() {
        return Needed::TooMany;
    }
    episodes_needed(successes as f64 / trials as f64, nearest, level).into()
}

/// For the difference or slope of shares of different episodes, from their corrected variance.
fn by_shares(counts: &[[u64; 2]], is_trend: bool, distance: f64, level: f64) -> Needed {
    let weights = if is_trend { trend::weights(counts.len()) } else { vec![1.0; counts.len()] };
    let part = |(weight, [successes, trials]): (&f64, &[u64; 2])| {
        // Agresti and Caffo's two successes and two failures keep the variance of a share of 0 or 1 positive.
        let share = (*successes as f64 + 1.0) / (*trials as f64 + 2.0);
        weight * weight * share * (1.0 - share)
    };
    observations_needed(distance, weights.iter().zip(counts).map(part).sum(), level).into()
}

/// For paired episodes, from how often only one side succeeds; if they never differ, from repeating the same
/// outcomes.
fn by_pairs(pairs: Pairs, nearest: f64, distance: f64, level: f64) -> Needed {
    let total = pairs.total();
    if total == 0 {
        return Needed::NotEstimated("there are no episodes");
    }
    if distance == 0.0 {
        return Needed::TooMany;
    }
    if pairs.only_first + pairs.only_second == 0 {
        let of = |times: usize| {
            let all = |count: u64| count * times as u64;
            let more = Pairs { both: all(pairs.both), neither: all(pairs.neither), ..Pairs::default() };
            !more.difference(1.0 - level).1.contains(nearest)
        };
        return times_needed(total as usize, of).map(|times| times * total as usize).into();
    }
    let [only_first, only_second] =
        [pairs.only_first, pairs.only_second].map(|count| count as f64 / total as f64);
    let difference = only_first - only_second;
    observations_needed(distance, only_first + only_second - difference * difference, level).into()
}

/// For values of episodes, from the spread between them or between the differences of paired episodes.
fn by_episodes(values: &[Vec<f64>], paired: bool, factor: f64, distance: f64, level: f64) -> Needed {
    let differences: Option<Vec<f64>> = match values {
        [first, second] if paired => Some(first.iter().zip(second).map(|(a, b)| a - factor * b).collect()),
        _ => None,
    };
    let variance = match &differences {
        Some(differences) => deviation(differences).map(|deviation| deviation * deviation),
        None => values
            .iter()
            .enumerate()
            .map(|(side, values)| {
                let factor = if side == 0 { 1.0 } else { factor };
                deviation(values).map(|deviation| factor * factor * deviation * deviation)
            })
            .sum(),
    };
    match variance {
        None => Needed::NotEstimated("a single episode has no spread"),
        Some(_) if distance == 0.0 => Needed::TooMany,
        // Without spread, the fewest episodes that a bootstrap accepts are enough.
        Some(0.0) => Needed::Number(mean::FEWEST),
        Some(variance) => observations_needed(distance, variance, level).into(),
    }
}
