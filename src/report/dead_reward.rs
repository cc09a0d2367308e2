//! Reward terms that pay almost nothing, and so have no influence on what is learned.

use super::model::{Arm, ReportInput};
use super::wording::{labels, listed};
use crate::kinds::reward::Rewards;
use crate::spec::section::RewardTerm;

/// A term that pays less than this share of its most is dead: a kernel `exp(-k e)` is that small where its
/// slope is, too.
const DEAD: f64 = 0.01;

/// One sentence for each arm with dead terms.
pub fn sentences(input: &ReportInput) -> Vec<String> {
    let of_arm = |(arm, name): (&Arm, String)| {
        let dead: Vec<String> = dead(arm).iter().map(|term| format!("`reward.{term}`")).collect();
        (!dead.is_empty()).then(|| {
            let (pay, teach) = if dead.len() == 1 { ("pays", "it teaches") } else { ("pay", "they teach") };
            format!("{name}: {} {pay} less than 1 % of the maximum, so {teach} nothing.", listed(&dead))
        })
    };
    input.arms.iter().zip(labels(&input.arms)).filter_map(of_arm).collect()
}

/// The terms of positive weight that pay next to nothing in the arm's first evaluation.
fn dead(arm: &Arm) -> Vec<&str> {
    let (Some(rate), Some(first)) = (arm.control_rate(), arm.evaluations.first()) else { return Vec::new() };
    let Some(terms) = arm.section().within::<Rewards>() else { return Vec::new() };
    let episodes = &first.evaluation.episodes;
    let paid = |term: &str| {
        let values: Vec<f64> =
            episodes.iter().filter_map(|one| one.reward_per_second.get(term).copied()).collect();
        crate::statistics::summary::mean(&values)
    };
    let is_dead = |(name, term): &(&str, crate::spec::Section<'_>)| {
        let most = term.value(RewardTerm::weight).filter(|weight| *weight > 0.0).map(|weight| weight * rate);
        most.zip(paid(name)).is_some_and(|(most, paid)| (0.0..DEAD * most).contains(&paid))
    };
    terms.sections().filter(is_dead).map(|(name, _)| name).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::report::model::Measured;
    use crate::spec::{Quantity, Value};

    #[test]
    fn a_term_that_pays_next_to_nothing_is_named_and_one_that_pays_or_costs_is_not() {
        let table = |entries: Vec<(&str, Value)>| {
            Value::Table(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
        };
        let number = |si: f64| Value::Quantity(Quantity { si, text: si.to_string() });
        let term = |weight: f64| table(vec![("weight", number(weight))]);
        let terms = vec![("torque", term(0.2)), ("base_orientation", term(0.3)), ("energy", term(-1.0))];
        let fields = [("reward", table(terms)), ("action", table(vec![("rate", number(125.0))]))];
        let paid = [("torque", 0.1), ("base_orientation", 30.0), ("energy", -0.1)];
        let reward_per_second = paid.map(|(name, paid)| (name.to_owned(), paid)).into();
        let episodes = vec![Episode { reward_per_second, ..Episode::default() }];
        let evaluation = Evaluation { episodes, ..Evaluation::default() };
        let arm = Arm {
            name: "walk".into(),
            fields: BTreeMap::from(fields.map(|(name, value)| (name.to_owned(), value))),
            evaluations: vec![Measured { stage: "evaluate.nominal".into(), evaluation }],
            ..Arm::default()
        };
        let input = ReportInput { arms: vec![arm], ..ReportInput::default() };
        assert_eq!(
            sentences(&input),
            ["walk: `reward.torque` pays less than 1 % of the maximum, so it teaches nothing."]
        );
    }
}
