//! What a report says was done in another way than in the paper: what the spec declares, the budget, other values of what
//! the paper has, and the keys that it does not have.

use super::model::{Arm, ReportInput};
use super::table::setup::{PAPER_SAMPLES, budget_samples};
use super::wording::{count, number};
use super::{paper_reward, paper_setting};
use crate::spec::Section;

/// What an arm may do beyond the paper: in words, and how to tell.
type Habit = (&'static str, fn(&Section) -> bool);

const BEYOND: &[Habit] = &[
    ("Episodes end early when the contacts contradict the schedule (`terminate.contact_schedule`)", |spec| {
        spec.section("terminate").is_some_and(|terms| terms.has("contact_schedule"))
    }),
    (
        "Episodes end when the base sinks or tilts, as by the authors' code (`terminate.base_height`, `terminate.base_tilt`)",
        |spec| has(spec, "terminate", "base_height") || has(spec, "terminate", "base_tilt"),
    ),
    ("The servo's targets may lie beyond the joints' limits (`action.targets = \"effort_limits\"`)", |spec| {
        is(spec, "action", "targets", "effort_limits")
    }),
    (
        "The servo explores in shares of the effort limits, not of the joints' ranges (`action.shares_of = \"effort_limits\"`)",
        |spec| is(spec, "action", "shares_of", "effort_limits"),
    ),
    (
        "Pre-training imitates a tracking controller instead of gravity compensation alone (`pretrain.kind = \"tracking\"`)",
        |spec| is(spec, "pretrain", "kind", "tracking"),
    ),
    ("The last samples are learnt with another exploration (`fine_tune.std`)", |spec| has(spec, "fine_tune", "std")),
    ("The last samples are learnt in another engine (`fine_tune.engine`)", |spec| {
        let engine = |part: &str| spec.section(part).and_then(|part| part.text_if("engine"));
        engine("fine_tune").is_some_and(|last| engine("physics") != Some(last))
    }),
    ("The last samples are learnt for another reward (`fine_tune.weights`)", |spec| has(spec, "fine_tune", "weights")),
    ("Episodes start anywhere in the reference motion (`initial.kind = \"reference\"`)", |spec| {
        is(spec, "initial", "kind", "reference")
    }),
    ("Samples are mirrored (`learn.symmetry`)", |spec| {
        has(spec, "learn", "symmetry") && !is(spec, "learn", "symmetry", "none")
    }),
    ("The learning rate follows the KL divergence (`learn.learning_rate.kl_target`)", |spec| {
        spec.section("learn").and_then(|learn| learn.section("learning_rate")).is_some_and(|rate| rate.has("kl_target"))
    }),
    ("The exploration falls over the training (`learn.std_decay`)", |spec| has(spec, "learn", "std_decay")),
    ("A time limit counts as a failure (`learn.time_limit`)", |spec| is(spec, "learn", "time_limit", "failure")),
    ("The horizon is given in seconds (`learn.discount_time`)", |spec| has(spec, "learn", "discount_time")),
    ("Rewards are scaled for the critic (`learn.reward_scale`)", |spec| {
        has(spec, "learn", "reward_scale") && !is(spec, "learn", "reward_scale", "none")
    }),
    ("The critic sees what the policy cannot (`learn.value.privileged`)", |spec| {
        spec.section("learn")
            .and_then(|learn| learn.section("value"))
            .is_some_and(|value| value.has("privileged") && value.flag("privileged"))
    }),
];

fn has(spec: &Section, section: &str, key: &str) -> bool {
    spec.section(section).is_some_and(|section| section.has(key))
}

fn is(spec: &Section, section: &str, key: &str, word: &str) -> bool {
    spec.section(section).is_some_and(|section| section.text_if(key) == Some(word))
}

/// The sentences, what the spec declares first.
pub fn sentences(input: &ReportInput) -> Vec<String> {
    let declared = input.deviations.iter().map(|text| format!("{}.", text.trim_end_matches('.')));
    declared.chain(budget(&input.arms)).chain(settings(&input.arms)).chain(beyond(&input.arms)).collect()
}

/// The smallest and the largest share of the paper's budget.
fn budget(arms: &[Arm]) -> Option<String> {
    let budgets: Vec<u64> = arms.iter().filter_map(budget_samples).collect();
    let (least, most) = (*budgets.iter().min()?, *budgets.iter().max()?);
    let share = |samples: u64| format!("{} %", number(100.0 * samples as f64 / PAPER_SAMPLES));
    match (least as f64 == PAPER_SAMPLES, least == most) {
        (true, true) => None,
        (_, true) => Some(format!("A run learns from {} samples, {} of the paper's 80 M.", count(least), share(least))),
        _ => Some(format!(
            "Runs learn from {} to {} samples, {} to {} of the paper's 80 M.",
            count(least),
            count(most),
            share(least),
            share(most)
        )),
    }
}

/// In what way the settings are not the paper's, part by part, and the rewards.
fn settings(arms: &[Arm]) -> Vec<String> {
    let parts = paper_setting::TOPICS.iter();
    let parts = parts.flat_map(|topic| told(arms, topic, |arm| paper_setting::differences(arm, topic)));
    parts.chain(told(arms, "The reward is", |arm| paper_reward::differences(&arm.section()))).collect()
}

/// A sentence for each way in which a part differs: `The reward is not the paper's in 3 of 6 runs: ...`.
fn told(arms: &[Arm], part: &str, differences: impl Fn(&Arm) -> Option<String>) -> Vec<String> {
    let mut found: Vec<(String, usize)> = Vec::new();
    for words in arms.iter().filter_map(differences) {
        match found.iter_mut().find(|(known, _)| *known == words) {
            Some((_, count)) => *count += 1,
            None => found.push((words, 1)),
        }
    }
    let said = |(words, count): (String, usize)| match count {
        all if all == arms.len() => format!("{part} not the paper's: {words}."),
        some => format!("{part} not the paper's in {some} of {} runs: {words}.", arms.len()),
    };
    found.into_iter().map(said).collect()
}

fn beyond(arms: &[Arm]) -> Vec<String> {
    let found = BEYOND.iter().filter_map(|(words, holds)| {
        let count = arms.iter().filter(|arm| holds(&arm.section())).count();
        match count {
            0 => None,
            all if all == arms.len() => Some(format!("{words}.")),
            some => Some(format!("{words}, in {some} of {} runs: compare only runs that agree on it.", arms.len())),
        }
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::spec::{Quantity, Table, Value};

    /// Keys that a decoded spec has whether its author wrote them or not.
    fn switched_off() -> Vec<(&'static str, Value)> {
        ["symmetry", "reward_scale"].map(|key| (key, Value::Text("none".into()))).to_vec()
    }

    fn arm(samples: u64, tracking: bool) -> Arm {
        let section = |entries: Vec<(&str, Value)>| -> Value {
            Value::Table(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
        };
        let kind = if tracking { "tracking" } else { "gravity_compensation" };
        let fields: Table = BTreeMap::from([
            ("learn".to_owned(), section([vec![("samples", Value::Count(samples))], switched_off()].concat())),
            ("pretrain".to_owned(), section(vec![("kind", Value::Text(kind.into()))])),
        ]);
        Arm { fields, ..Arm::default() }
    }

    #[test]
    fn the_papers_own_run_deviates_in_nothing_but_what_it_declares() {
        let mut input = ReportInput { arms: vec![arm(80_000_000, false)], ..ReportInput::default() };
        assert!(sentences(&input).is_empty());
        input.deviations = vec!["The robot is not the paper's.".into()];
        assert_eq!(sentences(&input), ["The robot is not the paper's."]);
    }

    #[test]
    fn other_values_ends_of_episodes_and_servos_are_told_with_the_runs_that_have_them() {
        let with = |sections: &[(&str, &str, Value)]| {
            let mut arm = arm(80_000_000, false);
            for (name, key, value) in sections {
                let section = arm.fields.entry((*name).to_owned()).or_insert_with(|| Value::Table(Table::new()));
                let Value::Table(section) = section else { panic!("a table") };
                section.insert((*key).to_owned(), value.clone());
            }
            arm
        };
        let rate = Value::Quantity(Quantity { si: 125.0, text: "125 Hz".into() });
        let soft = ("action", "targets", Value::Text("effort_limits".into()));
        let height = ("terminate", "base_height", Value::Table(Table::new()));
        let arms = vec![with(&[("action", "rate", rate), soft, height]), with(&[])];
        let said = sentences(&ReportInput { arms, ..ReportInput::default() });
        let expected = [
            "The rates and the engine are not the paper's in 1 of 2 runs: `action.rate` 125 Hz, not 250 Hz.",
            "Episodes end when the base sinks or tilts, as by the authors' code",
            "The servo's targets may lie beyond the joints' limits",
        ];
        assert_eq!(said.len(), expected.len(), "{said:?}");
        assert!(said.iter().zip(expected).all(|(said, words)| said.starts_with(words)), "{said:?}");
    }

    #[test]
    fn a_smaller_budget_and_what_only_some_runs_do_are_told() {
        let input = ReportInput { arms: vec![arm(4_000_000, true), arm(4_000_000, false)], ..ReportInput::default() };
        let said = sentences(&input);
        assert_eq!(said[0], "A run learns from 4.0 M samples, 5 % of the paper's 80 M.");
        assert!(said[1].contains("(`pretrain.kind = \"tracking\"`), in 1 of 2 runs"), "{said:?}");
    }
}
