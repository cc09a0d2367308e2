//! E0204 and E0816: numbers and stages of a claim that leave its test nothing to decide.

use super::measure::{TRAININGS, stages};
use super::{ArmScope, Scope, arms_in, at, name};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::fine_tune;
use crate::kinds::learn::{Learner, Ppo};
use crate::kinds::metric::{MetricKind, Source};
use crate::spec::claim::{Case, Claim, Over};
use crate::spec::suggest::listed;
use crate::spec::typed::InSection;
use crate::spec::{Quantity, Section};

/// The largest standard deviation of a number between 0 and 1 (Popoviciu's inequality).
const MOST_SPREAD_OF_A_SHARE: f64 = 0.5;

/// E0816: a stage that is its own baseline gives every run the same value, whatever it does.
pub fn baseline_is_another_stage(claim: &Claim, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    let own = &claim.metric.stage;
    let Some(baseline) = claim.baseline.as_ref().filter(|baseline| baseline.stage == *own) else { return };
    if baseline.twin.is_some() {
        return;
    }
    let value = if baseline.relative { "1" } else { "0" };
    let message = format!("the `baseline` of `{own}` is itself: the value of every run is {value}");
    let error = at(claim, "baseline", Diagnostic::error("E0816", message), "the stage of `metric`");
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

/// E0204: what is assumed of a share is possible for shares.
pub fn assumed_shares_are_possible(claim: &Claim, metric: &MetricKind, sink: &mut Sink) {
    if metric.unit != "%" || claim.baseline.is_some() || matches!(claim.over, Some(Over::Trend(_))) {
        return;
    }
    let mut report = |key: &str, quantity: &Quantity, range: &str| {
        let message = format!("`{key}` is out of range: {} is a share", metric.kind.name);
        let error = at(claim, key, Diagnostic::error("E0204", message), "not possible");
        sink.emit(
            error.help(format!("{} lies beyond the possible values: write one from {range}", quantity.text)),
        );
    };
    if let Some(spread) = claim.spread.as_ref().filter(|spread| spread.si > MOST_SPREAD_OF_A_SHARE) {
        report("spread", spread, "0 to 50 %");
    }
    if let Some(effect) = &claim.effect {
        let (least, range) = if claim.sides.len() == 2 {
            (-claim.expect.factor, "-100 to 100 %")
        } else {
            (0.0, "0 to 100 %")
        };
        if !(least..=1.0).contains(&effect.si) {
            report("effect", effect, range);
        }
    }
}

/// E0204: `until` lies between the first update and the end of every training that the claim is about. A
/// profile and `--set` shorten trainings for a quick look, in which all of a shorter one counts.
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
        let Some((arm, budget)) =
            budgets.into_iter().find(|(_, budget)| until < budget.first || until > budget.samples)
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
        sink.emit(at(claim, "until", Diagnostic::error("E0204", message), &remark).help(help));
        return;
    }
}

/// The samples of a training.
pub(super) struct Budget {
    /// After its first update.
    first: f64,
    /// At its end.
    pub(super) samples: f64,
}

impl Budget {
    pub(super) fn of(arm: &ArmScope, stage: &str) -> Option<Self> {
        let spec = Section::new(arm.fields);
        let samples = match stage {
            Learner::SECTION => spec.at(Ppo::stop_at).unwrap_or(u64::MAX).min(spec.at(Ppo::samples)?),
            _ => spec.at(fine_tune::Ppo::samples)?,
        } as f64;
        let rollout = spec.at(Ppo::rollout)?.max(1) as f64;
        // The last update is a whole one.
        Some(Self { first: rollout, samples: (samples / rollout).ceil() * rollout })
    }
}
