//! Judges claims: p values against the boundaries, and Holm's correction over the claims of a suite.

use super::quantifier::{Quantifier, Weighed};
use super::sample::{Found, samples};
use super::{Case, Evidence, Judged, Observed, Ruling, meaning, power};
use crate::kinds::metric::{self, MetricKind, Scale};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::report::estimate::Estimate;
use crate::spec::claim::{Claim, Over, Points, cases};
use crate::statistics::Interval;
use crate::statistics::multiplicity::holm;
use crate::statistics::region::Region;
use crate::statistics::test::{Measured, Sample, Test};

/// Judges the claims of a suite.
pub fn judge(claims: &[Claim], arms: &[Observed]) -> Vec<Judged> {
    let mut judged: Vec<Judged> = claims.iter().filter_map(|claim| draft(claim, arms)).collect();
    correct(&mut judged);
    judged
}

/// Applies Holm's correction over the claims of a page.
pub(super) fn correct(judged: &mut [Judged]) {
    // A claim that could not be tested still counts towards the number of claims.
    let adjusted = holm(&judged.iter().map(|claim| claim.p.unwrap_or(1.0)).collect::<Vec<_>>());
    for (claim, p) in judged.iter_mut().zip(adjusted) {
        claim.p_adjusted = claim.p.map(|_| p);
        if p > claim.alpha && matches!(claim.verdict, Ruling::Pass | Ruling::Fail) {
            claim.verdict = Ruling::NotEstablished;
        }
    }
    let count = judged.len();
    judged.iter_mut().for_each(|claim| claim.settled_by = power::settled_by(claim, count));
}

/// Verdict and p value of a claim before Holm's correction.
pub(super) fn together(
    quantifier: &Quantifier,
    cases: &[Weighed],
    failing: &[String],
    missing: &[String],
) -> (Ruling, Option<f64>) {
    let verdict = match quantifier.ruling(cases) {
        _ if !failing.is_empty() => Ruling::NotMeaningful,
        _ if !missing.is_empty() => Ruling::NotEstablished,
        ruling => ruling,
    };
    (verdict, quantifier.p(cases).filter(|_| failing.is_empty()))
}

/// What a comparison is judged by.
pub(super) struct Terms<'a> {
    /// The range in which the estimate is expected.
    pub region: Region,
    /// Two-sided level of the claim.
    pub alpha: f64,
    /// The test.
    pub test: Test<'a>,
}

/// The outcome of a comparison.
pub(super) struct Ruled {
    /// The estimate.
    pub measured: Measured,
    /// Its interval.
    pub interval: Option<Interval>,
    /// The p value in favour of the expectation.
    pub p_for: Option<f64>,
    /// The p value against the expectation.
    pub p_against: Option<f64>,
    /// PASS, FAIL or NOT ESTABLISHED.
    pub verdict: Ruling,
}

impl Terms<'_> {
    /// Judges a sample, given the levels for establishing and for refuting the expectation.
    pub fn rule(&self, sample: &Sample, levels: [f64; 2]) -> Ruled {
        let Self { region, alpha, test } = self;
        let measured = test.measure(sample);
        let interval = test.interval(sample, 1.0 - alpha);
        let at = |level: f64| if level < *alpha { test.interval(sample, 1.0 - level) } else { interval };
        let p = |boundary: f64| test.p(sample, boundary);
        let p_for = measured.value.and_then(|value| region.p_for(value, p));
        let p_against = measured.value.and_then(|value| region.p_against(value, p));
        // Where the p value is exact and the interval is computed by another method, both must agree.
        let decides = |p: Option<f64>, level: f64, agrees: &dyn Fn(Interval) -> bool| {
            p.is_some_and(|p| p <= level) && at(level).is_none_or(agrees)
        };
        let verdict = if decides(p_for, levels[0], &|interval| region.holds(interval)) {
            Ruling::Pass
        } else if decides(p_against, levels[1], &|interval| region.opposes(interval)) {
            Ruling::Fail
        } else {
            Ruling::NotEstablished
        };
        Ruled { measured, interval, p_for, p_against, verdict }
    }
}

impl Ruled {
    /// The smaller of the p values for and against the expectation.
    pub fn p(&self) -> Option<f64> {
        self.p_for.zip(self.p_against).map(|(p_for, p_against)| p_for.min(p_against))
    }
}

/// Judges a claim before Holm's correction; `None` for a metric or test that `check` would have refused.
fn draft(claim: &Claim, arms: &[Observed]) -> Option<Judged> {
    let (metric, statistic) = (metric::find(&claim.metric.name)?, statistic::find(&claim.test)?);
    let points: Vec<&Points> = arms.iter().map(|arm| arm.points).collect();
    let failing = meaning::failing(claim, metric, &cases(claim, &points), arms);
    let found = samples(claim, metric, statistic.unit(), arms);
    let quantifier =
        Quantifier::new(claim.over.as_ref(), found.cases.iter().map(|found| found.alternative.as_str()));
    let judged = found.cases.iter().enumerate().map(|(at, sample)| {
        let levels = quantifier.divisors(at).map(|divisor| claim.alpha / divisor);
        case(claim, metric, statistic, sample, levels)
    });
    let cases: Vec<Weighed> = judged.collect();
    let (verdict, p) = together(&quantifier, &cases, &failing, &found.missing);
    let alternatives = quantifier.alternatives(&cases);
    Some(Judged {
        id: claim.id.clone(),
        text: claim.text.clone(),
        metric: measured(claim),
        expect: expectation(claim),
        test: claim.test.clone(),
        unit: if statistic.unit() == Unit::Seed { "run" } else { "episode" }.to_owned(),
        alpha: claim.alpha,
        bounds: Region::of(claim, statistic).bounds().into(),
        factor: claim.expect.factor,
        over: claim.over.as_ref().map_or_else(String::new, Over::in_words),
        summary: claim.summary,
        verdict,
        p,
        p_adjusted: None,
        cases: cases.into_iter().map(|weighed| weighed.case).collect(),
        axis: claim.over.as_ref().and_then(Over::axis).unwrap_or_default().to_owned(),
        alternatives,
        missing: found.missing,
        failing,
        settled_by: None,
        paper: claim.paper.clone(),
    })
}

/// `evaluate.box.peak_ankle_torque - evaluate.flat`, `learn.area_under_curve until 5000000`.
pub fn measured(claim: &Claim) -> String {
    let mut measured = claim.metric.written();
    measured += &claim.until.map_or(String::new(), |until| format!(" until {until}"));
    measured += &claim.parameter.as_ref().map_or(String::new(), |parameter| format!(" along {parameter}"));
    if let Some(baseline) = &claim.baseline {
        let sign = if baseline.relative { '/' } else { '-' };
        measured += &format!(" {sign} {}", baseline.stage);
        measured += &baseline.twin.as_ref().map_or(String::new(), |twin| format!(" of {}", twin.written()));
    }
    measured
}

/// Whether a verdict is that of a claim as it is now: same sentence, metric and expectation.
pub fn is_of(judged: &Judged, claim: &Claim) -> bool {
    judged.id == claim.id
        && judged.text == claim.text
        && judged.metric == measured(claim)
        && judged.expect == expectation(claim)
}

/// `control=torque > control=position`.
pub fn expectation(claim: &Claim) -> String {
    let arm = |side: &str| claim.sides.get(side).map_or_else(|| side.to_owned(), |pattern| pattern.written());
    let expect = &claim.expect;
    let right = expect.right_written(arm);
    let within = expect.within.as_ref().map_or(String::new(), |within| format!(" within {}", within.text));
    let margin = claim.margin.as_ref().map_or(String::new(), |margin| format!(" (margin {})", margin.text));
    let over = match &claim.over {
        Some(Over::Some(axis)) => format!(" for some {axis}"),
        Some(Over::None(axis)) => format!(" for no {axis}"),
        Some(Over::Trend(axis)) => format!(" per point of {axis}"),
        Some(over) if over.count().is_some() => format!(" in {}", over.in_words()),
        _ => String::new(),
    };
    format!("{} {} {right}{within}{margin}{over}", arm(&expect.left), expect.relation.symbol())
}

/// One comparison, given the levels for establishing and for refuting the expectation.
fn case(
    claim: &Claim,
    metric: &MetricKind,
    statistic: &StatisticKind,
    Found { label, alternative, sample, sources }: &Found,
    levels: [f64; 2],
) -> Weighed {
    let test = Test {
        method: statistic.method,
        summary: claim.summary,
        trend: matches!(claim.over, Some(Over::Trend(_))),
        factor: claim.expect.factor,
        name: metric.kind.name,
    };
    let terms = Terms { region: Region::of(claim, statistic), alpha: claim.alpha, test };
    let ruled = terms.rule(sample, levels);
    let p = ruled.p();
    let Ruled { measured, interval, p_for, p_against, verdict } = ruled;
    let is_relative = claim.baseline.as_ref().is_some_and(|baseline| baseline.relative);
    let unit = match statistic.method {
        Method::ProbabilityOfImprovement => ("%", 0),
        _ if is_relative => ("", 2),
        _ => (metric.unit, metric.digits),
    };
    let estimate =
        Estimate { n: Some(measured.n.iter().sum()), ..Estimate::maybe(measured.value, unit.0, unit.1) };
    let remark = match (interval, measured.remark.is_empty(), metric.scale) {
        (None, true, Scale::Censored) => "too few runs reached the threshold for an interval".to_owned(),
        (None, true, _) => "too few observations for an interval".to_owned(),
        _ => measured.remark,
    };
    Weighed {
        case: Case {
            label: label.clone(),
            alternative: alternative.clone(),
            evidence: Some(Evidence::of(sample, statistic.method)),
            n: measured.n,
            fewest: measured.fewest,
            sides: measured.sides,
            estimate: estimate.within(interval),
            p,
            verdict,
            remark,
            sources: sources.clone(),
        },
        p_for,
        p_against,
    }
}
