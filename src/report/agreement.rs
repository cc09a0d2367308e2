//! Checks the claims of a record against the rest of it: verdicts against their values, values against the
//! table of all runs, and failing runs against how the policies do their task.

use serde_json::Value as Json;

use crate::kinds::metric::{self, Scale};
use crate::report::claim::{Case, Evidence, Judged, again, metric_path};
use crate::report::runs::RunRecord;
use crate::report::sidecar::Sidecar;
use crate::report::tasks::TaskRecord;

/// Largest relative difference between two numbers that are computed in the same way.
const TOLERANCE: f64 = 1e-9;

/// One sentence for each claim that disagrees, by the rules of this version.
pub fn disagreements(record: &Sidecar) -> Vec<String> {
    let judged = match again(&record.claims) {
        Ok(judged) => judged,
        Err(reason) => return vec![reason],
    };
    let pairs = record.claims.iter().zip(&judged);
    pairs.filter_map(|(claim, judged)| of_claim(record, claim, judged)).collect()
}

fn of_claim(record: &Sidecar, claim: &Judged, judged: &Judged) -> Option<String> {
    let of_verdict = (claim.verdict != judged.verdict).then(|| {
        let [told, given] = [claim.verdict, judged.verdict].map(|verdict| verdict.word());
        format!("is {told}, and its values give {given}")
    });
    let differs = || difference("", &numbers(claim), &numbers(judged));
    let reason = of_verdict
        .or_else(|| differs().map(|place| format!("has another `{place}` than its values give")))
        .or_else(|| values(record, claim))
        .or_else(|| failing(record, claim));
    reason.map(|reason| format!("its claim `{}` {reason}", claim.id))
}

/// The numbers that follow from the values. Texts are left out, as other versions may word them differently.
fn numbers(claim: &Judged) -> Json {
    let case = |case: &Case| {
        let Case { n, fewest, sides, estimate, p, verdict, .. } = case;
        let (value, low, high) = (estimate.value, estimate.low, estimate.high);
        serde_json::json!({
            "verdict": verdict, "p": p, "n": n, "fewest": fewest, "sides": sides,
            "estimate": { "value": value, "low": low, "high": high },
        })
    };
    let cases: Vec<Json> = claim.cases.iter().map(case).collect();
    serde_json::json!({
        "p": claim.p, "p_adjusted": claim.p_adjusted, "alternatives": claim.alternatives, "cases": cases,
    })
}

/// The path of the first value in which two JSON trees differ by more than rounding.
fn difference(path: &str, one: &Json, other: &Json) -> Option<String> {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    let is_same = match (one, other) {
        (Json::Object(one), Json::Object(other)) => {
            return one.iter().find_map(|(key, value)| {
                difference(&below(key), value, other.get(key).unwrap_or(&Json::Null))
            });
        }
        (Json::Array(one), Json::Array(other)) if one.len() == other.len() => {
            let pairs = one.iter().zip(other).enumerate();
            return pairs
                .into_iter()
                .find_map(|(at, (one, other))| difference(&below(&at.to_string()), one, other));
        }
        (Json::Number(one), Json::Number(other)) => {
            one.as_f64().zip(other.as_f64()).is_some_and(|(one, other)| is_close(one, other))
        }
        _ => one == other,
    };
    (!is_same).then(|| path.to_owned())
}

fn is_close(one: f64, other: f64) -> bool {
    (one - other).abs() <= TOLERANCE * one.abs().max(other.abs())
}

/// The baseline that a run's value is compared with.
struct Compared<'a> {
    /// The baseline's stage.
    stage: &'a str,
    /// The points of the twin arm; empty when the run is its own baseline.
    twin: &'a str,
    /// Whether the value is divided by it, instead of subtracting it.
    is_relative: bool,
}

/// Why a claim's values differ from the table of all runs. Metrics with a threshold, a parameter or an
/// `until` are not in that table.
fn values(record: &Sidecar, claim: &Judged) -> Option<String> {
    let asked = claim.metric.split_once(' ').map_or("", |(_, rest)| rest);
    let is_tabled =
        metric::find(&metric_path(claim).name).is_some_and(|metric| metric.scale != Scale::Censored);
    if !is_tabled || asked.contains("until ") || asked.contains("along ") {
        return None;
    }
    let compared = match asked.split_once(' ') {
        None => None,
        Some((sign, base)) => {
            let (stage, twin) = base.split_once(" of ").unwrap_or((base, ""));
            Some(Compared { stage, twin, is_relative: sign == "/" })
        }
    };
    claim.cases.iter().find_map(|case| of_case(record, claim, case, compared.as_ref()))
}

fn of_case(record: &Sidecar, claim: &Judged, case: &Case, compared: Option<&Compared>) -> Option<String> {
    let path = metric_path(claim);
    let told = told(case.evidence.as_ref()?);
    if told.len() != case.sources.len() {
        return Some(format!("has {} values of {} runs", told.len(), case.sources.len()));
    }
    case.sources.iter().zip(told).find_map(|(source, told)| {
        let run = record.runs.iter().find(|run| run.run == source.arm);
        let Some(run) = run else {
            return Some(format!("has a value of `{}`, which is none of the runs", source.arm));
        };
        let own = value(run, &path.stage, &path.name);
        let base = compared.map(|compared| {
            let of = match compared.twin {
                "" => Some(run),
                twin => record
                    .runs
                    .iter()
                    .find(|other| other.seed == run.seed && other.arm == with(&run.arm, twin)),
            };
            of.and_then(|of| value(of, compared.stage, &path.name))
        });
        let is_relative = compared.is_some_and(|compared| compared.is_relative);
        let known = match (own, base) {
            (own, None) => own,
            (Some(own), Some(Some(base))) if is_relative => Some(own / base),
            (Some(own), Some(Some(base))) => Some(own - base),
            _ => None,
        };
        let is_known = known.zip(told.value).is_some_and(|(one, other)| is_close_in_sum(one, other));
        // The mean of per-episode ratios is not the ratio of the means.
        let is_of_ratios = told.is_mean_of_episodes && is_relative;
        (!is_known && !is_of_ratios)
            .then(|| format!("has another value of `{}` than the table of all runs", run.run))
    })
}

/// Differences of nearly equal numbers lose digits, hence the absolute tolerance.
fn is_close_in_sum(one: f64, other: f64) -> bool {
    (one - other).abs() <= TOLERANCE * one.abs().max(other.abs()).max(1.0)
}

fn value(run: &RunRecord, stage: &str, metric: &str) -> Option<f64> {
    run.stages.get(stage)?.values.get(metric).copied()
}

/// The arm's name with these points replaced: `control=torque,ground=flat` with `ground=box`.
fn with(arm: &str, points: &str) -> String {
    let axis = |term: &str| term.split_once('=').map_or(term.to_owned(), |(axis, _)| axis.to_owned());
    let own = arm.split(',').map(|own| {
        let other = points.split(',').find(|other| axis(other) == axis(own));
        other.unwrap_or(own)
    });
    own.collect::<Vec<_>>().join(",")
}

/// A run's value as recorded with the claim.
struct Told {
    /// Absent when it is infinite.
    value: Option<f64>,
    is_mean_of_episodes: bool,
}

/// The values of the runs, in the order of the claim's sources.
fn told(evidence: &Evidence) -> Vec<Told> {
    let share = |successes: u64, trials: u64| Told {
        value: (trials > 0).then(|| successes as f64 / trials as f64),
        is_mean_of_episodes: true,
    };
    match evidence {
        Evidence::Runs { values, .. } => {
            let strata = values.iter().map(Vec::len).max().unwrap_or(0);
            let of_stratum = |at: usize| values.iter().filter_map(move |side| side.get(at)).flatten();
            let told = |value: &Option<f64>| Told { value: *value, is_mean_of_episodes: false };
            (0..strata).flat_map(of_stratum).map(told).collect()
        }
        Evidence::Counts(counts) => {
            counts.iter().map(|[successes, trials]| share(*successes, *trials)).collect()
        }
        Evidence::Pairs([both, only_first, only_second, neither]) => {
            let total = [both, only_first, only_second, neither]
                .into_iter()
                .fold(0, |sum: u64, n| sum.saturating_add(*n));
            let first = both.saturating_add(*only_first);
            vec![share(first, total), share(both.saturating_add(*only_second), total)]
        }
        Evidence::Episodes { values, .. } => {
            let mean = |values: &Vec<f64>| crate::statistics::summary::mean(values);
            values.iter().map(|values| Told { value: mean(values), is_mean_of_episodes: true }).collect()
        }
    }
}

/// Why a claim's list of failing runs is incomplete.
fn failing(record: &Sidecar, claim: &Judged) -> Option<String> {
    if !metric::find(&metric_path(claim).name).is_some_and(|metric| metric.needs_task) {
        return None;
    }
    let stage = metric_path(claim).stage;
    let fails = |run: &&RunRecord| {
        let mut of_arm = record.tasks.iter().filter(|task| task.arm == run.arm);
        let own = of_arm.clone().find(|task| task.stage == stage).or_else(|| of_arm.next());
        own.is_some_and(|task: &TaskRecord| task.seeds.contains(&run.seed))
    };
    let sources = claim.cases.iter().flat_map(|case| &case.sources);
    let compared = sources.filter_map(|source| record.runs.iter().find(|run| run.run == source.arm));
    // The name of an arm without points is empty.
    let is_told = |run: &RunRecord| {
        let named = [format!("{},seed={}", run.arm, run.seed), format!(",seed={}", run.seed)];
        claim.failing.iter().any(|told| *told == run.run || named.contains(told))
    };
    let untold = compared.filter(fails).find(|run| !is_told(run))?;
    Some(format!("does not say that `{}` fails its task", untold.run))
}
