//! W0510 and E0204: the returns that a claim compares are comparable, and possible.
//!
//! A return is the sum of an arm's own rewards over its own control steps. Between arms with different
//! rewards or control rates, a higher return does not mean better.

use std::collections::BTreeMap;

use super::range::Range;
use super::{ArmScope, Scope, arms_in, at, name};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::fine_tune::{self, FineTuning};
use crate::kinds::metric::{MetricKind, Source, Sums};
use crate::kinds::reward::Rewards;
use crate::kinds::task::Walk;
use crate::spec::claim::{Case, Claim, Expectation, MetricPath, Operand, Over, keys};
use crate::spec::section::RewardTerm;
use crate::spec::suggest::listed;
use crate::spec::typed::InSection;
use crate::spec::value::canonical_table;
use crate::spec::{Section, Table};

/// W0510, for the claim's first pair of arms that differ.
pub fn measure_the_same(claim: &Claim, metric: &MetricKind, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    if metric.sums == Sums::Nothing {
        return;
    }
    let pairs = cases.iter().filter_map(|case| Some([case.a, case.b?].map(|arm| &scope.arms[arm])));
    let differing = |pair: [&ArmScope; 2]| {
        let keys = differences(pair.map(|arm| arm.fields), metric.sums == Sums::PerStep);
        (!keys.is_empty()).then(|| (pair.map(|arm| name(arm.points)), keys))
    };
    let Some(([a, b], keys)) = pairs.into_iter().find_map(differing) else { return };
    let message = format!(
        "`{}` compares rewards that do not measure the same: `{a}` and `{b}` differ in {}",
        metric.kind.name,
        listed(keys.iter().map(String::as_str))
    );
    let warning = at(claim, MetricPath::NAME, Diagnostic::warning("W0510", message), "not the same sum");
    let help = match keys.iter().all(|key| *key == Position::rate.path()) {
        true => {
            "compare by `learn.final_return_time`, or compare what the robot does, for example \
             `evaluate.NAME.survival`"
        }
        false => {
            "compare what the robot does, for example `evaluate.NAME.survival`, or say in `[allow]` why \
             rewards are meant"
        }
    };
    sink.emit(warning.help(help));
}

/// E0204: return thresholds and compared returns are possible in an episode. Every reward term pays its
/// weight times a number from 0 to 1 in each control step.
pub fn are_possible(claim: &Claim, metric: &MetricKind, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    let is_curve = matches!(metric.source, Source::Learning(_)) && metric.sums != Sums::Nothing;
    if !is_curve || scope.shortened {
        return;
    }
    let arms = arms_in(cases, scope);
    let of =
        |arm: &&ArmScope| Some((name(arm.points), returns(Section::new(arm.fields), &claim.metric.stage)?));
    let Some(ranges) = arms.iter().map(of).collect::<Option<Vec<_>>>().filter(|all| !all.is_empty()) else {
        return;
    };
    if let Some(threshold) = claim.threshold {
        let beyond = ranges.iter().find(|(_, range)| threshold > range.high);
        let always = ranges.iter().find(|(_, range)| threshold <= range.low);
        let told = match (beyond, always) {
            (Some((arm, range)), _) => Some((
                "`threshold` lies beyond every return: no training reaches it",
                format!("an episode of the arm `{arm}` has {} at most", short(range.high)),
            )),
            (None, Some((arm, range))) => Some((
                "`threshold` lies below every return: every training begins beyond it",
                format!("an episode of the arm `{arm}` has {} at least", short(range.low)),
            )),
            (None, None) => None,
        };
        let (least, most) = common(&ranges);
        if let Some((message, remark)) = told {
            let error = at(claim, keys::Claim::threshold.name, Diagnostic::error("E0204", message), &remark);
            sink.emit(error.help(format!("write a return between {} and {}", short(least), short(most))));
        }
        return;
    }
    let Operand::Number(number) = &claim.expect.right else { return };
    let is_of_a_return = metric.sums == Sums::PerStep && claim.baseline.is_none();
    if !is_of_a_return || matches!(claim.over, Some(Over::Trend(_))) {
        return;
    }
    let outside = |(_, range): &&(String, Range)| !range.contains(number.si);
    if let Some((arm, range)) = ranges.iter().find(outside) {
        let message =
            format!("the number in `expect` is out of range: no return of an episode is {}", number.text);
        let remark =
            format!("those of the arm `{arm}` are from {} to {}", short(range.low), short(range.high));
        let error = at(claim, Expectation::RIGHT, Diagnostic::error("E0204", message), &remark);
        let (least, most) = common(&ranges);
        sink.emit(error.help(format!("write a return between {} and {}", short(least), short(most))));
    }
}

/// The returns possible in all arms.
fn common(ranges: &[(String, Range)]) -> (f64, f64) {
    let ends = ranges.iter().map(|(_, range)| range);
    let least = ends.clone().map(|range| range.low).fold(f64::NEG_INFINITY, f64::max);
    (least, ends.map(|range| range.high).fold(f64::INFINITY, f64::min))
}

/// The possible returns of an episode of a training: `None` if its length or its reward is unknown.
fn returns(spec: Section, stage: &str) -> Option<Range> {
    let steps = (spec.at(Walk::episode)? * spec.at(Position::rate)?).ceil();
    let tuned = match stage == FineTuning::SECTION {
        true => spec.at(fine_tune::Ppo::weights).unwrap_or_default(),
        false => BTreeMap::new(),
    };
    let terms = spec.within::<Rewards>()?;
    let weight = |(name, term): (&str, Section)| {
        tuned.get(name).copied().or_else(|| term.value(RewardTerm::weight)).unwrap_or(0.0)
    };
    let weights: Vec<f64> = terms.sections().map(weight).collect();
    let sum = |keep: fn(f64) -> f64| steps * weights.iter().map(|weight| keep(*weight)).sum::<f64>();
    let range = Range { low: sum(|weight| weight.min(0.0)), high: sum(|weight| weight.max(0.0)) };
    (range.low.is_finite() && range.high.is_finite()).then_some(range)
}

/// The reward terms and the control rate in which two arms differ. Terms with zero weight do not count.
fn differences(arms: [&Table; 2], with_rate: bool) -> Vec<String> {
    let [a, b] = arms.map(Section::new);
    let (ours, theirs) = (paid(a), paid(b));
    let lone = ours
        .iter()
        .filter(|term| !theirs.contains(term))
        .chain(theirs.iter().filter(|term| !ours.contains(term)));
    let mut keys: Vec<String> = lone.map(|(name, _)| format!("reward.{name}")).collect();
    let rate = |spec: Section| spec.at(Position::rate);
    keys.extend((with_rate && rate(a) != rate(b)).then(|| Position::rate.path()));
    keys.sort();
    keys.dedup();
    keys
}

/// The reward terms with nonzero weight, each in canonical form.
fn paid(spec: Section) -> Vec<(String, serde_json::Value)> {
    let terms =
        spec.within::<Rewards>().into_iter().flat_map(|rewards| rewards.sections().collect::<Vec<_>>());
    let paid = terms.filter(|(_, term)| term.value(RewardTerm::weight) != Some(0.0));
    paid.map(|(name, term)| (name.to_owned(), canonical_table(term.table()))).collect()
}
