//! E0204: the numbers of a claim lie where the values of its metric can.

use super::values::Budget;
use super::{Scope, arms_in, at, name};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::metric::{MetricKind, Scale};
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Case, Claim, Operand, Over};

/// E0204: the number that an arm is compared with is one that the metric, its difference or its ratio can
/// have. The ends of the range are: whether they can be told from the rest depends on the test (W0511).
pub fn number_is_possible(claim: &Claim, statistic: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    let Operand::Number(number) = &claim.expect.right else { return };
    if statistic.method == Method::ProbabilityOfImprovement || matches!(claim.over, Some(Over::Trend(_))) {
        return;
    }
    let [least, most] = range(claim, metric);
    if (least..=most).contains(&number.si) {
        return;
    }
    let of = match &claim.baseline {
        Some(baseline) if baseline.relative => format!("a ratio of `{}`", metric.kind.name),
        Some(_) => format!("a difference of `{}`", metric.kind.name),
        None => format!("`{}`", metric.kind.name),
    };
    let is_ratio = claim.baseline.as_ref().is_some_and(|baseline| baseline.relative);
    let written = |end: f64| match metric.unit {
        "%" if !is_ratio => format!("{} %", short(100.0 * end)),
        unit if unit.is_empty() || is_ratio => short(end),
        unit => format!("{} {unit}", short(end)),
    };
    let possible = match (least.is_finite(), most.is_finite()) {
        (true, true) => format!("from {} to {}", written(least), written(most)),
        (true, false) => format!("of {} or more", written(least)),
        _ => format!("of {} or less", written(most)),
    };
    let message = format!("the number in `expect` is out of range: {of} is never {}", number.text);
    let error = at(claim, "expect.right", Diagnostic::error("E0204", message), "not possible");
    sink.emit(error.help(format!("write a number {possible}")));
}

/// What the value of a run can be.
fn range(claim: &Claim, metric: &MetricKind) -> [f64; 2] {
    let [least, most] = metric.bounds;
    match &claim.baseline {
        None => [least, most],
        Some(baseline) if baseline.relative && least >= 0.0 => [0.0, f64::INFINITY],
        Some(baseline) if baseline.relative => [f64::NEG_INFINITY, f64::INFINITY],
        Some(_) => [least - most, most - least],
    }
}

/// E0204: no two arms differ in their samples to a threshold by more than a training has. A
/// comparison of one arm with a number is E0807.
pub fn samples_are_in_the_training(
    claim: &Claim,
    statistic: &StatisticKind,
    metric: &MetricKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    let is_share = statistic.method == Method::ProbabilityOfImprovement;
    if metric.scale != Scale::Censored || is_share || claim.baseline.is_some() || scope.shortened {
        return;
    }
    let of = |arm| Some((arm, Budget::of(arm, &claim.metric.stage)?.samples));
    let longest =
        arms_in(cases, scope).into_iter().filter_map(of).max_by(|(_, one), (_, other)| one.total_cmp(other));
    let Some((arm, samples)) = longest else { return };
    let (expect, margin) = (&claim.expect, &claim.margin);
    let distances =
        [("expect.offset", &expect.offset), ("expect.within", &expect.within), ("margin", margin)];
    let far = distances
        .into_iter()
        .find(|(_, distance)| distance.as_ref().is_some_and(|far| far.si.abs() > samples));
    let Some((key, _)) = far else { return };
    let message = format!("a distance of `{}` is longer than `{}`", metric.kind.name, claim.metric.stage);
    let remark = format!("the arm `{}` ends after {samples} samples", name(arm.points));
    let error = at(claim, key, Diagnostic::error("E0204", message), &remark);
    sink.emit(error.help(format!("write {samples} or less")));
}
