//! Judges the claims of a record again from their recorded values, with the tests that judged them, to find
//! verdicts, p values and estimates that do not follow from these values.

use super::judge::{Ruled, Terms, correct, together};
use super::quantifier::{Quantifier, Weighed};
use super::{Case, Evidence, Judged};
use crate::kinds::metric;
use crate::kinds::statistic::{self, StatisticKind};
use crate::report::estimate::Estimate;
use crate::spec::claim::{MetricPath, Over};
use crate::statistics::region::Region;
use crate::statistics::test::{Sample, Test};

/// Judges claims again. `Err` names the claim that cannot be judged and the reason.
pub fn again(claims: &[Judged]) -> Result<Vec<Judged>, String> {
    let mut judged = Vec::with_capacity(claims.len());
    for claim in claims {
        judged.push(one(claim).map_err(|reason| format!("its claim `{}` {reason}", claim.id))?);
    }
    correct(&mut judged);
    Ok(judged)
}

/// Judges one claim, before Holm's correction.
fn one(claim: &Judged) -> Result<Judged, String> {
    let unknown =
        |what: &str, name: &str| format!("has the {what} `{name}`, which this version does not know");
    let metric = metric_path(claim).name;
    let metric = metric::find(&metric).ok_or_else(|| unknown("metric", &metric))?;
    let statistic = statistic::find(&claim.test).ok_or_else(|| unknown("test", &claim.test))?;
    let over = match claim.over.as_str() {
        "" => None,
        words => Some(Over::of_words(words).ok_or_else(|| unknown("quantifier", words))?),
    };
    let test = Test {
        method: statistic.method,
        summary: claim.summary,
        trend: matches!(over, Some(Over::Trend(_))),
        factor: claim.factor,
        name: metric.kind.name,
    };
    let region = Region::between(claim.bounds).ok_or("has no boundary")?;
    let terms = Terms { region, alpha: claim.alpha, test };
    let alternatives = claim.cases.iter().map(|case| case.alternative.as_str());
    let quantifier = Quantifier::new(over.as_ref(), alternatives);
    let mut cases = Vec::with_capacity(claim.cases.len());
    for (at, case) in claim.cases.iter().enumerate() {
        let evidence = case.evidence.as_ref().ok_or("has a comparison without values")?;
        let sample = sample(evidence, statistic).ok_or("has values that its test does not take")?;
        let levels = quantifier.divisors(at).map(|divisor| claim.alpha / divisor);
        cases.push(weighed(case, terms.rule(&sample, levels)));
    }
    let (verdict, p) = together(&quantifier, &cases, &claim.failing, &claim.missing);
    let alternatives = quantifier.alternatives(&cases);
    let cases = cases.into_iter().map(|weighed| weighed.case).collect();
    Ok(Judged { verdict, p, p_adjusted: None, alternatives, cases, settled_by: None, ..claim.clone() })
}

/// The comparison with its numbers replaced by those of `ruled`.
fn weighed(case: &Case, ruled: Ruled) -> Weighed {
    let p = ruled.p();
    let Ruled { measured, interval, p_for, p_against, verdict } = ruled;
    let estimate = Estimate { value: measured.value, ..case.estimate.clone() }.within(interval);
    let (n, fewest, sides) = (measured.n, measured.fewest, measured.sides);
    Weighed { case: Case { n, fewest, sides, estimate, p, verdict, ..case.clone() }, p_for, p_against }
}

/// Rebuilds the sample from its recorded values.
fn sample(evidence: &Evidence, statistic: &StatisticKind) -> Option<Sample> {
    let episodes = |sides: Vec<Vec<f64>>, paired: bool| Some(Sample::Episodes { sides, paired });
    let shares = |count: u64, value: f64| std::iter::repeat_n(value, usize::try_from(count).unwrap_or(0));
    let is_of_runs = statistic.unit() == statistic::Unit::Seed;
    match evidence {
        // A missing value is a threshold that was never reached: it ranks above all others.
        Evidence::Runs { values, episodes } if is_of_runs => {
            let stratum =
                |runs: &Vec<Option<f64>>| runs.iter().map(|run| run.unwrap_or(f64::INFINITY)).collect();
            let sides = values.iter().map(|side| side.iter().map(stratum).collect()).collect();
            Some(Sample::Runs { sides, episodes: *episodes })
        }
        Evidence::Counts(counts) if !is_of_runs => {
            let side = |[successes, trials]: &[u64; 2]| {
                let failures = trials.checked_sub(*successes)?;
                (*trials <= MOST).then(|| shares(*successes, 1.0).chain(shares(failures, 0.0)).collect())
            };
            episodes(counts.iter().map(side).collect::<Option<_>>()?, false)
        }
        Evidence::Pairs(counts) if !is_of_runs && counts.iter().all(|count| *count <= MOST) => {
            let side = |values: [f64; 4]| {
                counts.iter().zip(values).flat_map(|(n, value)| shares(*n, value)).collect()
            };
            episodes(vec![side([1.0, 1.0, 0.0, 0.0]), side([1.0, 0.0, 1.0, 0.0])], true)
        }
        Evidence::Episodes { values, paired } if !is_of_runs => episodes(values.clone(), *paired),
        _ => None,
    }
}

/// Upper limit of a recorded count, above that of any evaluation: a number in a file must not exhaust memory.
const MOST: u64 = 10_000_000;

/// The stage and metric of a claim, without its baseline and parameters.
pub fn metric_path(claim: &Judged) -> MetricPath {
    let written = claim.metric.split(' ').next().unwrap_or_default();
    let (stage, name) = written.rsplit_once('.').unwrap_or_default();
    MetricPath { stage: stage.to_owned(), name: name.to_owned() }
}
