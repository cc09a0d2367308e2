//! The rulings: intervals against boundaries, Holm's correction over the claims of a suite.

use super::quantifier::{Quantifier, Weighed};
use super::sample::{Found, samples};
use super::{Case, Judged, Observed, Ruling};
use crate::kinds::metric::{self, MetricKind, Scale};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::report::estimate::Estimate;
use crate::spec::claim::{Claim, Operand, Over};
use crate::statistics::Interval;
use crate::statistics::multiplicity::holm;
use crate::statistics::region::Region;
use crate::statistics::test::Test;

/// Judges the claims of a suite.
pub fn judge(claims: &[Claim], arms: &[Observed]) -> Vec<Judged> {
    let drafts = claims.iter().filter_map(|claim| draft(claim, arms));
    let (mut judged, p): (Vec<Judged>, Vec<Option<f64>>) = drafts.unzip();
    let tested: Vec<(usize, f64)> = p.into_iter().enumerate().filter_map(|(at, p)| Some((at, p?))).collect();
    let adjusted = holm(&tested.iter().map(|(_, p)| *p).collect::<Vec<_>>());
    for ((at, _), p) in tested.into_iter().zip(adjusted) {
        judged[at].p_adjusted = Some(p);
        if p > judged[at].alpha {
            judged[at].verdict = Ruling::NotEstablished;
        }
    }
    judged
}

/// A claim before the others are looked at, with the p value that is corrected for their number; `None` for a metric or
/// test that `check` would have refused.
fn draft(claim: &Claim, arms: &[Observed]) -> Option<(Judged, Option<f64>)> {
    let (metric, statistic) = (metric::find(&claim.metric.name)?, statistic::find(&claim.test)?);
    let found = samples(claim, (metric, statistic.unit), arms);
    let quantifier = Quantifier::new(claim.over.as_ref(), found.cases.iter().map(|found| found.alternative.as_str()));
    let judged = found.cases.iter().enumerate().map(|(at, sample)| {
        let levels = quantifier.divisors(at).map(|divisor| claim.alpha / divisor);
        case(claim, (metric, statistic), sample, levels)
    });
    let cases: Vec<Weighed> = judged.collect();
    let mut verdict = quantifier.ruling(&cases);
    if !found.missing.is_empty() {
        verdict = Ruling::NotEstablished;
    }
    let (p, alternatives) = (quantifier.p(&cases), quantifier.alternatives(&cases));
    let judged = Judged {
        id: claim.id.clone(),
        text: claim.text.clone(),
        metric: claim.metric.written(),
        expect: expectation(claim),
        test: claim.test.clone(),
        unit: if statistic.unit == Unit::Seed { "run" } else { "episode" }.to_owned(),
        alpha: claim.alpha,
        bounds: Region::of(claim, statistic).bounds().into(),
        verdict,
        p_adjusted: None,
        cases: cases.into_iter().map(|weighed| weighed.case).collect(),
        axis: claim.over.as_ref().and_then(Over::axis).unwrap_or_default().to_owned(),
        alternatives,
        missing: found.missing,
        paper: claim.paper.clone(),
    };
    Some((judged, p))
}

/// `control=torque > control=position`.
fn expectation(claim: &Claim) -> String {
    let arm = |side: &str| claim.sides.get(side).map_or_else(|| side.to_owned(), |pattern| pattern.written());
    let expect = &claim.expect;
    let right = match &expect.right {
        Operand::Arm(side) => arm(side),
        Operand::Number(number) => number.text.clone(),
    };
    let within = expect.within.as_ref().map_or(String::new(), |within| format!(" within {}", within.text));
    let margin = claim.margin.as_ref().map_or(String::new(), |margin| format!(" (margin {})", margin.text));
    let over = match &claim.over {
        Some(Over::Some(axis)) => format!(" for some {axis}"),
        Some(Over::None(axis)) => format!(" for no {axis}"),
        _ => String::new(),
    };
    format!("{} {} {right}{within}{margin}{over}", arm(&expect.left), expect.relation.symbol())
}

/// One comparison, at the levels at which it must hold and be opposed.
fn case(
    claim: &Claim,
    (metric, statistic): (&MetricKind, &StatisticKind),
    Found { label, sample, sources, .. }: &Found,
    levels: [f64; 2],
) -> Weighed {
    let region = Region::of(claim, statistic);
    let test =
        Test { method: statistic.method, summary: claim.summary, boundary: region.boundary(), name: metric.kind.name };
    let measured = test.measure(sample);
    let interval = test.interval(sample, 1.0 - claim.alpha);
    let at = |level: f64| if level < claim.alpha { test.interval(sample, 1.0 - level) } else { interval };
    let verdict = match levels.map(at) {
        [Some(interval), _] if region.holds(interval) => Ruling::Pass,
        [_, Some(interval)] if region.opposes(interval) => Ruling::Fail,
        _ => Ruling::NotEstablished,
    };
    let p = measured.p.filter(|_| region.is_spoken_of_by(statistic.method));
    let unit =
        if statistic.method == Method::ProbabilityOfImprovement { ("%", 0) } else { (metric.unit, metric.digits) };
    let estimate = Estimate { n: Some(measured.n.iter().sum()), ..Estimate::maybe(measured.value, unit.0, unit.1) };
    let remark = match (interval, measured.remark.is_empty(), metric.scale) {
        (None, true, Scale::Censored) => "too few runs reached the threshold for an interval".to_owned(),
        (None, true, _) => "too few observations for an interval".to_owned(),
        _ => measured.remark,
    };
    let level = if verdict == Ruling::Pass { levels[0] } else { levels[1] };
    let verdict = if p.is_some_and(|p| p > level) { Ruling::NotEstablished } else { verdict };
    let expected = measured.value.map(|value| region.holds(Interval { low: value, high: value }));
    let (label, sides, sources) = (label.clone(), measured.sides, sources.clone());
    let (n, fewest) = (measured.n, measured.fewest);
    Weighed {
        case: Case { label, n, fewest, sides, estimate: estimate.within(interval), p, verdict, remark, sources },
        expected,
    }
}
