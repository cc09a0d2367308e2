//! The rulings: intervals against boundaries, Holm's correction over the claims of a suite.

use super::quantifier::{Quantifier, Weighed};
use super::sample::{Found, samples};
use super::test::Test;
use super::{Case, Judged, Observed, Ruling};
use crate::kinds::metric::{self, MetricKind, Scale};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::report::estimate::Estimate;
use crate::report::statistics::Interval;
use crate::report::statistics::multiplicity::holm;
use crate::spec::claim::{Claim, Operand, Over, Relation};

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
    let name = format!("{}/{label}", claim.id);
    let region = Region::of(claim, statistic);
    let test = Test { method: statistic.method, summary: claim.summary, boundary: region.boundary(), name: &name };
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
    let (label, n, sides, sources) = (label.clone(), measured.n, measured.sides, sources.clone());
    Weighed {
        case: Case { label, n, sides, estimate: estimate.within(interval), p, verdict, remark, sources },
        expected,
    }
}

/// Where a claim expects the estimate.
#[derive(Clone, Copy, Debug)]
struct Region {
    /// Where equality lies: 0, the claim's number, or one half.
    centre: f64,
    relation: Relation,
    /// Distance of the boundary from the centre: the margin, or the tolerance of `==`.
    distance: f64,
}

impl Region {
    fn of(claim: &Claim, statistic: &StatisticKind) -> Self {
        let centre = match (&claim.expect.right, statistic.method) {
            (Operand::Number(number), _) => number.si,
            (_, Method::ProbabilityOfImprovement) => 0.5,
            _ => 0.0,
        };
        let distance = claim.expect.within.as_ref().or(claim.margin.as_ref()).map_or(0.0, |quantity| quantity.si);
        Self { centre, relation: claim.expect.relation, distance }
    }

    /// Whether a p value of this method speaks of the boundary: it must have one, and where it does not lie at equality the
    /// method must be able to test another place.
    fn is_spoken_of_by(&self, method: Method) -> bool {
        let only_equality = matches!(method, Method::MannWhitney | Method::Mcnemar | Method::Newcombe);
        self.relation != Relation::Equal && (self.distance == 0.0 || !only_equality)
    }

    /// The boundary; of a range the middle.
    fn boundary(&self) -> f64 {
        match self.bounds() {
            (Some(bound), None) | (None, Some(bound)) => bound,
            _ => self.centre,
        }
    }

    /// The lower boundary of what is expected, if it has one, and the upper.
    fn bounds(&self) -> (Option<f64>, Option<f64>) {
        let (centre, distance) = (self.centre, self.distance);
        match self.relation {
            Relation::Greater => (Some(centre + distance), None),
            Relation::AtLeast => (Some(centre - distance), None),
            Relation::Less => (None, Some(centre - distance)),
            Relation::AtMost => (None, Some(centre + distance)),
            Relation::Equal => (Some(centre - distance), Some(centre + distance)),
        }
    }

    /// Whether the whole interval lies where it is expected; a boundary that it touches is not crossed.
    fn holds(&self, interval: Interval) -> bool {
        let (low, high) = self.bounds();
        low.is_none_or(|low| interval.low > low) && high.is_none_or(|high| interval.high < high)
    }

    /// Whether the whole interval lies on the other side.
    fn opposes(&self, interval: Interval) -> bool {
        let (low, high) = self.bounds();
        low.is_some_and(|low| interval.high < low) || high.is_some_and(|high| interval.low > high)
    }
}
