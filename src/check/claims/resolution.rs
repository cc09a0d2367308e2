//! W1004: numbers of a claim below the resolution of the measurement.
//!
//! A share of episodes changes in steps of one episode. Other values are reported with a few decimals; a
//! hundredth of the last decimal is negligible.

use super::range::{in_unit, is_ratio};
use super::{Scope, arms_in, at};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy;
use crate::kinds::metric::{MetricKind, Scale, Source};
use crate::kinds::statistic::{Method, StatisticKind, Unit};
use crate::spec::Quantity;
use crate::spec::claim::{Case, Claim, Expectation, Over, Relation, keys};

/// Decimals of reported ratios.
const DIGITS_OF_A_RATIO: i32 = 2;

/// The smallest meaningful number.
struct Smallest {
    /// In the metric's SI unit.
    number: f64,
    /// What it corresponds to: `one of the 160 episodes of an arm`.
    told: String,
}

/// W1004 for distances between arms so small that they act like zero, and for a spread that runs cannot have.
pub fn numbers_can_be_told_from_nothing(
    claim: &Claim,
    test: &StatisticKind,
    metric: &MetricKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    let arms = arms_in(cases, scope);
    let episodes = arms.iter().filter_map(|arm| deploy::episodes(arm.fields, &claim.metric.stage)).max();
    let runs = arms.iter().map(|arm| arm.runs).max().unwrap_or(1).max(1);
    let of_a_share = episodes.filter(|_| metric.scale == Scale::Success && !is_ratio(claim));
    let decimals = || {
        let digits = if is_ratio(claim) { DIGITS_OF_A_RATIO } else { metric.digits as i32 };
        let percent = if metric.unit == "%" && !is_ratio(claim) { 0.01 } else { 1.0 };
        let number = percent * libm::pow(10.0, f64::from(-digits - 2));
        Smallest { number, told: "a hundredth of the last decimal that is reported".to_owned() }
    };
    if test.method != Method::ProbabilityOfImprovement && !matches!(claim.over, Some(Over::Trend(_))) {
        let smallest = match (of_a_share, test.unit()) {
            (Some(episodes), Unit::Episode) => Smallest {
                number: 1.0 / episodes as f64,
                told: format!("one of the {episodes} episodes of a policy"),
            },
            (Some(episodes), Unit::Seed) => Smallest {
                number: 1.0 / (episodes * runs) as f64,
                told: format!("one of the {} episodes of an arm", episodes * runs),
            },
            (None, _) => decimals(),
        };
        distance(claim, metric, &smallest, sink);
    }
    let Some(spread) = &claim.spread else { return };
    let smallest = match of_a_share.filter(|_| runs > 1 && !matches!(metric.source, Source::Whole(_))) {
        // One run has one success more or less than all others.
        Some(episodes) => Smallest {
            number: 1.0 / (episodes as f64 * libm::sqrt(runs as f64)),
            told: format!("that of {runs} runs of which one differs in one of {episodes} episodes"),
        },
        None => decimals(),
    };
    if is_smaller(spread, &smallest) {
        let message = format!("`spread` of `{}` is too small for runs that differ at all", claim.id);
        let remark = format!("less than {}", smallest.told);
        let warning = at(claim, keys::Claim::spread.name, Diagnostic::warning("W1004", message), &remark);
        let least = at_least(smallest.number, claim, metric);
        sink.emit(warning.help(format!(
            "write the standard deviation between runs that you expect, {least} or more, or remove `spread`"
        )));
    }
}

fn is_smaller(quantity: &Quantity, smallest: &Smallest) -> bool {
    let size = quantity.si.abs();
    // The number may have been rounded.
    0.0 < size && size < 0.99 * smallest.number
}

/// The number in the metric's unit, rounded up to three digits so that it is itself accepted.
fn at_least(number: f64, claim: &Claim, metric: &MetricKind) -> String {
    let percent = if metric.unit == "%" && !is_ratio(claim) { 100.0 } else { 1.0 };
    let scale = libm::pow(10.0, libm::floor(libm::log10(number * percent)) - 2.0);
    in_unit(libm::ceil(number * percent / scale) * scale / percent, claim, metric)
}

/// The claim's distance below the smallest number, with what the claim then decides.
fn distance(claim: &Claim, metric: &MetricKind, smallest: &Smallest, sink: &mut Sink) {
    let keys = [
        (Expectation::OFFSET, &claim.expect.offset),
        (Expectation::WITHIN, &claim.expect.within),
        (keys::Claim::margin.name, &claim.margin),
    ];
    let found = keys.into_iter().filter_map(|(key, distance)| Some((key, distance.as_ref()?)));
    for (key, small) in found.filter(|(_, distance)| is_smaller(distance, smallest)) {
        let mut without = claim.expect.clone();
        without.offset = None;
        let plain = without.written();
        let text = small.text.trim_start_matches('-');
        let message = match claim.expect.relation {
            Relation::Equal => format!("`{}` cannot be established: {text} is not a tolerance", claim.id),
            _ => format!(
                "`{}` decides what `{plain}` decides: {text} is not a meaningful difference",
                claim.id
            ),
        };
        let remark = format!("less than {}", smallest.told);
        let warning = at(claim, key, Diagnostic::warning("W1004", message), &remark);
        let least = at_least(smallest.number, claim, metric);
        sink.emit(warning.help(match (key, claim.expect.relation) {
            (_, Relation::Equal) => format!("write a difference that does not matter, {least} or more"),
            ("margin", _) => format!("write a difference that matters, {least} or more, or remove `margin`"),
            _ => format!("write a difference that matters, {least} or more, or `{plain}`"),
        }));
    }
}
