//! The rulings: intervals against boundaries, Holm's correction over the claims of a suite.

use super::sample::{Found, samples};
use super::test::Test;
use super::{Case, Judged, Observed, Ruling};
use crate::kinds::metric::{self, MetricKind, Scale};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::report::estimate::Estimate;
use crate::report::statistics::Interval;
use crate::report::statistics::multiplicity::holm;
use crate::spec::claim::{Claim, Operand, Relation};

/// Judges the claims of a suite.
pub fn judge(claims: &[Claim], arms: &[Observed]) -> Vec<Judged> {
    let drafts: Vec<Judged> = claims.iter().filter_map(|claim| draft(claim, arms)).collect();
    let tested: Vec<usize> = (0..drafts.len()).filter(|at| p_of(&drafts[*at]).is_some()).collect();
    let adjusted = holm(&tested.iter().filter_map(|at| p_of(&drafts[*at])).collect::<Vec<_>>());
    let mut judged = drafts;
    for (at, p) in tested.into_iter().zip(adjusted) {
        judged[at].p_adjusted = Some(p);
        if p > judged[at].alpha {
            judged[at].verdict = Ruling::NotEstablished;
        }
    }
    judged
}

/// A claim before the others are looked at; `None` for a metric or test that `check` would have refused.
fn draft(claim: &Claim, arms: &[Observed]) -> Option<Judged> {
    let (metric, statistic) = (metric::find(&claim.metric.name)?, statistic::find(&claim.test)?);
    let found = samples(claim, (metric, statistic.unit), arms);
    let count = found.cases.len();
    let cases: Vec<Case> = found.cases.iter().map(|sample| case(claim, (metric, statistic), sample, count)).collect();
    let mut verdict = together(&cases);
    if !found.missing.is_empty() {
        verdict = Ruling::NotEstablished;
    }
    Some(Judged {
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
        cases,
        missing: found.missing,
        paper: claim.paper.clone(),
    })
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
    format!("{} {} {right}{within}{margin}", arm(&expect.left), expect.relation.symbol())
}

/// One comparison of `count`.
fn case(
    claim: &Claim,
    (metric, statistic): (&MetricKind, &StatisticKind),
    Found { label, sample, sources }: &Found,
    count: usize,
) -> Case {
    let name = format!("{}/{label}", claim.id);
    let region = Region::of(claim, statistic);
    let test = Test { method: statistic.method, summary: claim.summary, boundary: region.boundary(), name: &name };
    let measured = test.measure(sample);
    let interval = test.interval(sample, 1.0 - claim.alpha);
    // For a claim about each of several comparisons the opposite is established by any one of them, which needs the
    // stricter level (Bonferroni); that all of them pass needs none (Berger 1982).
    let strict = if count > 1 { test.interval(sample, 1.0 - claim.alpha / count as f64) } else { interval };
    let verdict = match (interval, strict) {
        (Some(interval), _) if region.holds(interval) => Ruling::Pass,
        (_, Some(strict)) if region.opposes(strict) => Ruling::Fail,
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
    let verdict = if p.is_some_and(|p| p > claim.alpha) { Ruling::NotEstablished } else { verdict };
    let (label, n, sides, sources) = (label.clone(), measured.n, measured.sides, sources.clone());
    Case { label, n, sides, estimate: estimate.within(interval), p, verdict, remark, sources }
}

/// A claim of several comparisons passes when all do and fails when one does.
fn together(cases: &[Case]) -> Ruling {
    let any = |ruling: Ruling| cases.iter().any(|case| case.verdict == ruling);
    match (any(Ruling::Fail), any(Ruling::NotEstablished), cases.is_empty()) {
        (true, ..) => Ruling::Fail,
        (false, false, false) => Ruling::Pass,
        _ => Ruling::NotEstablished,
    }
}

/// The p value with which a claim enters Holm's correction: the largest of its comparisons when all must pass, the
/// smallest times their number when one is enough to fail it. Without a p value in every comparison there is none.
fn p_of(judged: &Judged) -> Option<f64> {
    let all: Vec<f64> = judged.cases.iter().map(|case| case.p).collect::<Option<_>>()?;
    let failed = judged.cases.iter().filter(|case| case.verdict == Ruling::Fail).filter_map(|case| case.p);
    match failed.reduce(f64::min) {
        Some(least) => Some((least * all.len() as f64).min(1.0)),
        None => all.into_iter().reduce(f64::max),
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
