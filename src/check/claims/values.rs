//! E0204 and E0816: numbers and stages of a claim that make its test trivial.

use super::measure::{TRAININGS, stages};
use super::training::Budget;
use super::{ArmScope, Scope, arms_in, at, name};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::metric::{MetricKind, Source};
use crate::spec::claim::{Case, Claim, keys};
use crate::spec::suggest::listed;

/// E0816: a stage that is its own baseline gives every run the same value.
pub fn baseline_is_another_stage(claim: &Claim, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    let own = &claim.metric.stage;
    let Some(baseline) = claim.baseline.as_ref().filter(|baseline| baseline.stage == *own) else { return };
    if baseline.twin.is_some() {
        return;
    }
    let value = if baseline.relative { "1" } else { "0" };
    let message = format!("the `baseline` of `{own}` is itself: the value of every run is {value}");
    let error =
        at(claim, keys::Claim::baseline.name, Diagnostic::error("E0816", message), "the stage of `metric`");
    let known = arms_in(cases, scope).first().map(|arm| stages(arm.fields)).unwrap_or_default();
    let is_alike = |stage: &&String| {
        *stage != own && TRAININGS.contains(&stage.as_str()) == TRAININGS.contains(&own.as_str())
    };
    let others: Vec<&str> = known.iter().filter(is_alike).map(String::as_str).collect();
    sink.emit(match others.as_slice() {
        [] => error.help("remove `baseline`: the arms have no other stage that measures it"),
        others => error.help(format!(
            "name another stage, or remove `baseline`; the others are {}",
            listed(others.iter().copied())
        )),
    });
}

/// E0204: `until` is between the first update and the end of every training of the claim. If a profile or
/// `--set` shortens a training for a quick look, all of it counts.
pub fn until_is_in_the_training(
    claim: &Claim,
    metric: &MetricKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    let Some(until) =
        claim.until.filter(|_| matches!(metric.source, Source::Learning(_)) && !scope.shortened)
    else {
        return;
    };
    let baseline = claim.baseline.as_ref().map(|baseline| baseline.stage.as_str());
    for stage in [Some(claim.metric.stage.as_str()), baseline].into_iter().flatten() {
        let of = |arm: &ArmScope| Some((name(arm.points), Budget::of(arm, stage)?));
        let budgets: Vec<(String, Budget)> = arms_in(cases, scope).into_iter().filter_map(of).collect();
        // A training without samples is reported separately (E0804).
        let Some((arm, budget)) = budgets
            .into_iter()
            .find(|(_, budget)| budget.samples > 0.0 && (until < budget.first || until > budget.samples))
        else {
            continue;
        };
        let (message, remark, help) = match until > budget.samples {
            true => (
                format!("`until` lies beyond the end of `{stage}`"),
                format!("the arm `{arm}` ends after {} samples", budget.samples),
                format!("write {} or less, or remove `until`", budget.samples),
            ),
            false => (
                format!("`until` lies before the first update of `{stage}`"),
                format!("the first update of the arm `{arm}` is after {} samples", budget.first),
                format!("write {} or more, or remove `until`", budget.first),
            ),
        };
        sink.emit(
            at(claim, keys::Claim::until.name, Diagnostic::error("E0204", message), &remark).help(help),
        );
        return;
    }
}
