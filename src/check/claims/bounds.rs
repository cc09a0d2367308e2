//! E0204: the numbers of a claim are possible values of its metric.

use super::range::{self, Range, in_unit, is_ratio};
use super::training::Budget;
use super::{Scope, arms_in, at, name};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::metric::{MetricKind, Scale};
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Case, Claim, Expectation, Operand, Over, keys};
use crate::statistics::region::Region;

/// E0204: the number that an arm is compared with is a possible value of the metric, its difference or its
/// ratio. The ends of the range are allowed: whether a test can exclude them is checked by W0511.
pub fn number_is_possible(claim: &Claim, statistic: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    let Operand::Number(number) = &claim.expect.right else { return };
    if statistic.method == Method::ProbabilityOfImprovement || matches!(claim.over, Some(Over::Trend(_))) {
        return;
    }
    let range = range::of_a_run(claim, metric);
    if range.contains(number.si) {
        return;
    }
    let of = measured(claim, metric);
    let message = format!("the number in `expect` is out of range: {of} is never {}", number.text);
    let error = at(claim, Expectation::RIGHT, Diagnostic::error("E0204", message), "not possible");
    sink.emit(error.help(format!("write a number {}", range.in_words(claim, metric))));
}

/// `survival`, `a difference of survival`.
fn measured(claim: &Claim, metric: &MetricKind) -> String {
    match (&claim.baseline, is_ratio(claim)) {
        (_, true) => format!("a ratio of `{}`", metric.kind.name),
        (Some(_), _) => format!("a difference of `{}`", metric.kind.name),
        (None, _) => format!("`{}`", metric.kind.name),
    }
}

/// E0204: two values of the metric can differ by the distances of the claim.
pub fn distances_are_possible(
    claim: &Claim,
    statistic: &StatisticKind,
    metric: &MetricKind,
    cases: &[Case],
    sink: &mut Sink,
) {
    let range = range::of_the_estimate(claim, statistic, metric, cases.len());
    let is_share = statistic.method == Method::ProbabilityOfImprovement;
    let written = |end: f64| if is_share { short(end) } else { in_unit(end, claim, metric) };
    let mut report = |key: &str, what: &str, distance: &str, most: f64| {
        let of = if is_share { "a probability".to_owned() } else { measured(claim, metric) };
        let message = format!("{what} is out of range: no values of {of} are {distance} apart");
        let error = at(claim, key, Diagnostic::error("E0204", message), "not possible");
        sink.emit(error.help(format!("write {} or less", written(most))));
    };
    if let Some(offset) = claim.expect.offset.as_ref().filter(|offset| !range.contains(offset.si)) {
        let most = if offset.si > 0.0 { range.high } else { -range.low };
        let distance = offset.text.trim_start_matches('-');
        return report(Expectation::OFFSET, "the distance in `expect`", distance, most);
    }
    let most = range.farthest_from(Region::of(claim, statistic).centre());
    let (within, margin) = (&claim.expect.within, &claim.margin);
    let distances = [
        (Expectation::WITHIN, "the tolerance of `==`", within),
        (keys::Claim::margin.name, "`margin`", margin),
    ];
    for (key, what, distance) in distances {
        if let Some(distance) = distance.as_ref().filter(|distance| distance.si > most) {
            report(key, what, &distance.text, most);
        }
    }
}

/// E0204: the assumed effect and spread and the paper's number are possible for the metric. Returns whether the
/// effect is.
pub fn assumed_values_are_possible(
    claim: &Claim,
    metric: &MetricKind,
    cases: &[Case],
    sink: &mut Sink,
) -> bool {
    let mut report = |key: &str, what: &str, range: Range| {
        let message = format!("`{key}` is out of range for {what} of `{}`", metric.kind.name);
        let error = at(claim, key, Diagnostic::error("E0204", message), "not possible");
        sink.emit(error.help(format!("write a number {}", range.in_words(claim, metric))));
    };
    // The standard deviation of values in a range is at most half its width (Popoviciu's inequality).
    let most = 0.5 * range::of_a_run(claim, metric).width();
    if claim.spread.as_ref().is_some_and(|spread| spread.si > most) {
        report(keys::Claim::spread.name, "a standard deviation", Range { low: 0.0, high: most });
    }
    let range = range::of_the_arms(claim, metric, cases.len());
    let what = match (claim.sides.len(), &claim.over) {
        (_, Some(Over::Trend(_))) => "a slope",
        (1, _) => "a value",
        _ => "a difference",
    };
    let number = claim.paper.as_ref().and_then(|paper| paper.number.as_ref());
    if number.is_some_and(|number| !range.contains(number.si)) {
        report(&keys::Paper::number.path(), what, range);
    }
    let Some(_) = claim.effect.as_ref().filter(|effect| !range.contains(effect.si)) else { return true };
    report(keys::Claim::effect.name, what, range);
    false
}

/// E0204: two arms cannot differ in their samples to a threshold by more than the whole training. A
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
    let distances = [
        (Expectation::OFFSET, &expect.offset),
        (Expectation::WITHIN, &expect.within),
        (keys::Claim::margin.name, margin),
    ];
    let far = distances
        .into_iter()
        .find(|(_, distance)| distance.as_ref().is_some_and(|far| far.si.abs() > samples));
    let Some((key, _)) = far else { return };
    let message = format!("a distance of `{}` is longer than `{}`", metric.kind.name, claim.metric.stage);
    let remark = format!("the arm `{}` ends after {samples} samples", name(arm.points));
    let error = at(claim, key, Diagnostic::error("E0204", message), &remark);
    sink.emit(error.help(format!("write {samples} or less")));
}
