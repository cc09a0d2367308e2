//! Warnings that a reader needs to interpret a report.

use super::comparison::are_paired;
use super::crossing;
use super::dead_reward;
use super::model::{Arm, ReportInput, Update};
use super::rates;
use super::table::health::shown;
use super::table::setup::{budget_samples, learning_samples};
use super::untrained;
use super::verdict::{judge, stands_still};
use super::wording::{count, labels, number};
use crate::kinds::pretrain::Pretraining;
use crate::kinds::reward::Rewards;
use crate::spec::section;
use crate::spec::typed::InSection;
use crate::statistics::summary::mean;

/// The warnings of a report, most serious first.
pub fn warnings(input: &ReportInput) -> Vec<String> {
    let names = labels(&input.arms);
    let mut warnings = Vec::new();
    for (arm, name) in input.arms.iter().zip(&names) {
        warnings.extend(failures(arm, name));
    }
    for (arm, name) in input.arms.iter().zip(&names) {
        warnings.extend(of_evaluations(arm, name));
    }
    warnings.extend(crossing::warnings(&input.arms.iter().collect::<Vec<_>>()));
    warnings.extend(rates::warning(&input.arms));
    warnings.push(format!(
        "Only one seed{}. The intervals are about these policies, not about the methods.",
        if input.arms.len() > 1 { " per arm: differences between the arms may be chance" } else { "" }
    ));
    warnings.extend(budgets(input, &names));
    warnings.extend(robots(input));
    warnings.extend(rewards(input));
    warnings.extend(dead_reward::sentences(input));
    for (arm, name) in input.arms.iter().zip(&names) {
        warnings.extend(of_learning(arm, name));
    }
    warnings
}

fn failures(arm: &Arm, name: &str) -> Vec<String> {
    let failed = arm.failures.iter().map(|failure| {
        format!(
            "{name}: stage `{}` has no result, and what depends on it is missing here: {}.",
            failure.stage, failure.reason
        )
    });
    let nothing = arm.evaluations.iter().all(|measured| measured.evaluation.episodes.is_empty());
    failed.chain(nothing.then(|| format!("{name}: nothing was evaluated."))).collect()
}

/// Warnings about the evaluations of an arm.
pub fn of_evaluations(arm: &Arm, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    for measured in &arm.evaluations {
        let (evaluation, place) = (&measured.evaluation, arm.place_of(measured));
        if arm.travels() && stands_still(evaluation) {
            found.push(format!("{name}, {place}: survives by standing still; that is not the task."));
        }
        if let Some(reason) = judge(arm, evaluation).unjudged {
            found.push(format!("{name}, {place}: the task is not judged: {reason}."));
        }
        if let Some(first) = evaluation.diverged().next() {
            found.push(format!(
                "{name}, {place}: the physics diverged in {} of {} episodes (`R0001`), first in `{}`.",
                evaluation.diverged().count(),
                evaluation.episodes.len(),
                first.stream
            ));
        }
    }
    found
}

fn budgets(input: &ReportInput, names: &[String]) -> Vec<String> {
    let budgets: Vec<Option<u64>> = input.arms.iter().map(budget_samples).collect();
    let mut found = Vec::new();
    let of_arm = |(arm, name): (&Arm, &String)| {
        let samples = budget_samples(arm).filter(|samples| *samples > 0);
        let (samples, share) = (samples?, arm.budget_share.filter(|share| *share < 1.0)?);
        Some(format!("{name} {} samples, {} %", count(samples), number(100.0 * share)))
    };
    let small: Vec<String> = input.arms.iter().zip(names).filter_map(of_arm).collect();
    if !small.is_empty() {
        found.push(format!("The budget is below the baseline's: {}.", small.join("; ")));
    }
    if budgets.windows(2).any(|pair| pair[0] != pair[1]) {
        found.push("The arms have different budgets: their results are not comparable.".to_string());
    }
    if let [first, rest @ ..] = &input.arms[..] {
        for (arm, name) in rest.iter().zip(&names[1..]) {
            for own in &arm.evaluations {
                let twin = first.evaluations.iter().find(|one| one.is_the_same_as(own));
                if twin.is_some_and(|twin| !are_paired(&twin.evaluation, &own.evaluation)) {
                    let (stage, engine) = (&own.stage, &own.evaluation.engine);
                    found.push(format!(
                        "{name}, `{stage}` in {engine}: its episodes are not those of {}.",
                        names[0]
                    ));
                }
            }
        }
    }
    found
}

/// Forces, torques and even speeds of different robots are not comparable, as size and weight differ.
fn robots(input: &ReportInput) -> Option<String> {
    let model = |arm: &Arm| arm.section().at(section::Robot::model);
    let mut models: Vec<String> = input.arms.iter().filter_map(model).collect();
    models.sort();
    models.dedup();
    (models.len() > 1).then(|| {
        format!(
            "The arms are of different robots ({}): differences between them are those of the robots, too.",
            models.join(", ")
        )
    })
}

/// Returns are comparable only between arms with the same reward.
fn rewards(input: &ReportInput) -> Option<String> {
    let trained = |arm: &&Arm| !arm.updates.is_empty();
    let mut paid = input.arms.iter().filter(trained).map(|arm| arm.fields.get(Rewards::SECTION));
    let first = paid.next()?;
    paid.any(|reward| reward != first).then(|| {
        "The arms are paid by different rewards, so neither their returns nor their learning curves say \
         which is better: \
         compare what the evaluations measure."
            .to_owned()
    })
}

fn of_learning(arm: &Arm, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    if untrained::is_untrained(arm) {
        let (cause, what) = (untrained::cause(arm), untrained::network(arm));
        found.push(format!("{name}: the policy learned nothing (`W0508`), {cause}: this is {what}."));
    }
    if learning_samples(arm) == Some(0) {
        let network = if arm.kind::<Pretraining>().is_empty() {
            "an untrained network"
        } else {
            "the pre-trained network alone"
        };
        found.push(format!("{name}: nothing was learned (`learn.samples = 0`): this is {network}."));
    }
    let mut codes: Vec<&str> = shown(arm).map(|finding| finding.code.as_str()).collect();
    codes.sort_unstable();
    codes.dedup();
    if !codes.is_empty() {
        found.push(format!(
            "{name}: the run-time checks of the training warn ({}), see Learning.",
            codes.join(", ")
        ));
    }
    let tenth = arm.updates.len().div_ceil(10).max(1);
    let mut ends = arm.updates.rchunks(tenth).map(|updates| {
        mean(&updates.iter().filter_map(|update: &Update| update.return_mean).collect::<Vec<_>>())
    });
    if let (Some(Some(last)), Some(Some(before))) = (ends.next(), ends.next())
        && arm.updates.len() >= 20
        && last > before + 0.03 * before.abs()
    {
        let rise = 100.0 * (last - before) / before.abs().max(1e-9);
        found.push(format!(
            "{name}: the return was still rising when the budget ended ({} % over the last tenth).",
            number(rise)
        ));
    }
    if let (Some(budget), Some(last)) = (learning_samples(arm), arm.updates.last())
        && (last.samples as f64) < 0.97 * budget as f64
    {
        found.push(format!(
            "{name}: learning ended at {} of {} samples.",
            count(last.samples),
            count(budget)
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::report::model::Measured;
    use crate::spec::Value;

    fn arm(samples: u64) -> Arm {
        let learn = BTreeMap::from([("samples".to_string(), Value::Count(samples))]);
        let task = BTreeMap::from([("kind".to_string(), Value::Text("walk".into()))]);
        let fields = BTreeMap::from([
            ("learn".to_string(), Value::Table(learn)),
            ("task".to_string(), Value::Table(task)),
        ]);
        let episode = Episode { survived: true, duration: 16.0, ..Episode::default() };
        let evaluation =
            Evaluation { engine: "rapier".into(), episodes: vec![episode; 8], ..Evaluation::default() };
        let evaluations = vec![Measured { stage: "evaluate.nominal".into(), evaluation }];
        Arm { name: "walk".into(), fields, evaluations, ..Arm::default() }
    }

    /// An arm with three updates and this reward weight for speed, whose critic alone learns in the first
    /// `warm_up`.
    fn trained(weight: u64, warm_up: u64) -> Arm {
        let mut arm = arm(80_000_000);
        let updates = (0..3).map(|update| Update { update, samples: 80_000_000, ..Update::default() });
        arm.updates = updates.collect();
        let speed = Value::Table(BTreeMap::from([("weight".to_string(), Value::Count(weight))]));
        arm.fields.insert(
            "reward".into(),
            Value::Table(BTreeMap::from([("velocity_tracking".to_string(), speed)])),
        );
        if let Some(Value::Table(learn)) = arm.fields.get_mut("learn") {
            learn.insert("warm_up".into(), Value::Count(warm_up));
        }
        arm
    }

    #[test]
    fn arms_of_different_robots_are_told() {
        let with = |model: &str| {
            let robot = BTreeMap::from([("model".to_string(), Value::Text(model.into()))]);
            let mut arm = trained(3, 0);
            arm.fields.insert("robot".into(), Value::Table(robot));
            arm
        };
        assert!(of(vec![with("tocabi"), with("atlas")]).contains("different robots (atlas, tocabi)"));
        assert!(!of(vec![with("tocabi"), with("tocabi")]).contains("different robots"));
    }

    #[test]
    fn arms_of_different_rewards_are_not_told_apart_by_their_returns() {
        assert!(of(vec![trained(3, 0), trained(8, 0)]).contains("paid by different rewards"));
        assert!(!of(vec![trained(3, 0), trained(3, 0)]).contains("different rewards"));
    }

    #[test]
    fn a_policy_that_was_only_warmed_up_is_told() {
        assert!(
            of(vec![trained(3, 3)]).contains(
                "walk: the policy learned nothing (`W0508`), all updates were the critic's warm-up"
            )
        );
        assert!(!of(vec![trained(3, 2)]).contains("learned nothing"));
    }

    fn of(arms: Vec<Arm>) -> String {
        warnings(&ReportInput { arms, ..ReportInput::default() }).join("\n")
    }

    #[test]
    fn one_seed_a_small_budget_and_standing_still_are_said() {
        let with = |samples: u64, budget_share: Option<f64>| of(vec![Arm { budget_share, ..arm(samples) }]);
        let text = with(3_000_000, Some(0.0375));
        assert!(text.contains("Only one seed"), "{text}");
        assert!(text.contains("The budget is below the baseline's: walk 3.0 M samples, 3.75 %."), "{text}");
        assert!(text.contains("survives by standing still"), "{text}");
        assert!(!with(80_000_000, Some(1.0)).contains("budget"));
        assert!(!with(3_000_000, None).contains("budget"), "nothing to compare it with");
    }

    #[test]
    fn a_policy_that_learned_nothing_is_called_so() {
        assert!(of(vec![arm(0)]).contains("this is an untrained network"));
        let mut pretrained = arm(0);
        let kind = BTreeMap::from([("kind".to_string(), Value::Text("tracking".into()))]);
        pretrained.fields.insert("pretrain".to_string(), Value::Table(kind));
        pretrained.budget_share = Some(0.0);
        let text = of(vec![pretrained]);
        assert!(text.contains("the pre-trained network alone") && !text.contains("is below"), "{text}");
    }

    #[test]
    fn episodes_are_compared_with_those_of_the_same_stage_and_engine_only() {
        let measured = |stage: &str, stream: &str| {
            let episode = Episode { stream: stream.into(), ..Episode::default() };
            let evaluation =
                Evaluation { engine: "rapier".into(), episodes: vec![episode], ..Evaluation::default() };
            Measured { stage: stage.into(), evaluation }
        };
        let with = |evaluations: Vec<Measured>| Arm { evaluations, ..arm(80_000_000) };
        let both = || with(vec![measured("evaluate.nominal", "1000/0"), measured("evaluate.box", "2000/0")]);
        let said = of(vec![both(), with(vec![measured("evaluate.box", "2000/0")])]);
        assert!(
            !said.contains("not those of"),
            "the first stage of one is not the first of the other: {said}"
        );
        let said = of(vec![both(), with(vec![measured("evaluate.box", "3000/0")])]);
        assert!(said.contains("`evaluate.box` in rapier: its episodes are not those of"), "{said}");
    }

    #[test]
    fn unequal_budgets_are_said() {
        assert!(of(vec![arm(3_000_000), arm(4_000_000)]).contains("different budgets"));
    }

    #[test]
    fn a_return_that_still_rises_is_said() {
        let mut rising = arm(1000);
        rising.updates = (1..=100)
            .map(|update| Update {
                samples: 10 * update,
                return_mean: Some(update as f64),
                ..Update::default()
            })
            .collect();
        assert!(of(vec![rising]).contains("still rising"));
    }
}
