//! W0510: the rewards that a claim compares measure the same.
//!
//! A return is the sum of an arm's own rewards over its own control steps. Between arms that are rewarded
//! differently, or at another rate, more return is not more of anything.

use super::{ArmScope, Scope, at, name};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::metric::{MetricKind, Sums};
use crate::kinds::reward::Rewards;
use crate::spec::claim::{Case, Claim};
use crate::spec::section::RewardTerm;
use crate::spec::suggest::listed;
use crate::spec::value::canonical_table;
use crate::spec::{Section, Table};

/// The key of the control rate.
const RATE: &str = "action.rate";

/// W0510, for the first of the claim's pairs of arms that differ.
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
    let warning = at(claim, "metric.name", Diagnostic::warning("W0510", message), "not the same sum");
    let help = match keys.iter().all(|key| key == RATE) {
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

/// The reward terms and the control rate in which two arms differ. A term of weight zero pays nothing.
fn differences(arms: [&Table; 2], with_rate: bool) -> Vec<String> {
    let [a, b] = arms.map(Section::new);
    let (ours, theirs) = (paid(a), paid(b));
    let lone = ours
        .iter()
        .filter(|term| !theirs.contains(term))
        .chain(theirs.iter().filter(|term| !ours.contains(term)));
    let mut keys: Vec<String> = lone.map(|(name, _)| format!("reward.{name}")).collect();
    let rate = |spec: Section| spec.at(Position::rate);
    keys.extend((with_rate && rate(a) != rate(b)).then(|| RATE.to_owned()));
    keys.sort();
    keys.dedup();
    keys
}

/// The reward terms that pay anything, each as what it means.
fn paid(spec: Section) -> Vec<(String, serde_json::Value)> {
    let terms =
        spec.within::<Rewards>().into_iter().flat_map(|rewards| rewards.sections().collect::<Vec<_>>());
    let paid = terms.filter(|(_, term)| term.value(RewardTerm::weight) != Some(0.0));
    paid.map(|(name, term)| (name.to_owned(), canonical_table(term.table()))).collect()
}
