//! What would settle a claim that is open: how many runs or episodes, from the variance that was observed.

use super::{Case, Evidence, Judged, Ruling};
use crate::statistics::power::{alike_runs_needed, episodes_needed, runs_needed};
use crate::statistics::summary::deviation;
use crate::statistics::trend;

/// How many runs per arm or episodes would settle a claim of so many that are corrected together; `None` for a claim that is
/// settled, that lacks runs, or whose robots fail their task.
pub fn settled_by(claim: &Judged, claims: usize) -> Option<String> {
    if claim.verdict != Ruling::NotEstablished || !claim.missing.is_empty() {
        return None;
    }
    let level = claim.alpha / claims.max(1) as f64;
    let open = || claim.cases.iter().filter(|case| claim.cases.len() == 1 || case.verdict == Ruling::NotEstablished);
    let needed: Vec<Option<usize>> = open().map(|case| needed(claim, case, level)).collect();
    let most = needed.iter().copied().collect::<Option<Vec<usize>>>().and_then(|all| all.into_iter().max());
    let corrected = if claims > 1 { format!(", corrected for {claims} claims") } else { String::new() };
    Some(match (most, claim.unit.as_str()) {
        (None, _) => "no number of seeds that can be run settles it at the observed estimate".to_owned(),
        (Some(runs), "run") => {
            format!("about {runs} seeds per arm settle it (80 % power at the observed estimate and spread{corrected})")
        }
        (Some(episodes), _) => {
            format!("about {episodes} episodes settle it at the observed share{corrected}")
        }
    })
}

fn needed(claim: &Judged, case: &Case, level: f64) -> Option<usize> {
    let value = case.estimate.value?;
    let ends = claim.bounds.iter().flatten();
    // The boundary that is nearest is the hardest to be told from.
    let distance = ends.map(|bound| (value - bound).abs()).fold(f64::INFINITY, f64::min);
    match case.evidence.as_ref()? {
        Evidence::Runs { values, .. } => {
            let spread = |(side, strata): (usize, &Vec<Vec<Option<f64>>>)| {
                let factor = if side == 0 { 1.0 } else { claim.factor };
                let weights = match claim.over.starts_with("trend") {
                    true => trend::weights(strata.len()),
                    false => vec![1.0 / strata.len() as f64; strata.len()],
                };
                // The variance of a weighted sum of means.
                let squares: Vec<f64> = strata
                    .iter()
                    .map(|runs| {
                        let runs: Vec<f64> = runs.iter().copied().collect::<Option<_>>()?;
                        deviation(&runs).map(|deviation| deviation * deviation)
                    })
                    .collect::<Option<_>>()?;
                let parts = weights.iter().zip(&squares).map(|(weight, square)| weight * weight * square);
                Some(factor * libm::sqrt(parts.sum()))
            };
            let spreads: Vec<f64> = values.iter().enumerate().map(spread).collect::<Option<_>>()?;
            if distance == 0.0 {
                return None;
            }
            match spreads.iter().all(|spread| *spread == 0.0) {
                true => alike_runs_needed(level),
                false => runs_needed(distance, &spreads, level),
            }
        }
        Evidence::Counts(counts) => {
            let [[successes, trials]] = counts.as_slice() else { return None };
            let nearest = claim
                .bounds
                .iter()
                .flatten()
                .copied()
                .min_by(|a, b| (value - a).abs().total_cmp(&(value - b).abs()))?;
            episodes_needed(*successes as f64 / *trials as f64, nearest, level)
        }
        Evidence::Pairs(_) | Evidence::Episodes { .. } => None,
    }
}
