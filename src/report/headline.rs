//! The result in a few sentences, computed from the evaluations: what each arm does and fails to do.

use super::metric::Metric;
use super::model::{Arm, Measured, ReportInput};
use super::table::conditions::{all_conditions, conditions, variations};
use super::verdict::{Verdict, asked_speed, judge};
use super::wording::{labels, number, with_interval};
use crate::kinds::fine_tune;
use crate::kinds::physics::Physics;
use crate::outcome::Evaluation;
use crate::sim::EngineName;

/// One paragraph per arm.
pub fn paragraphs(input: &ReportInput) -> Vec<String> {
    let names = labels(&input.arms);
    input.arms.iter().zip(&names).map(|(arm, name)| paragraph(arm, name)).collect()
}

fn paragraph(arm: &Arm, name: &str) -> String {
    let mut evaluated = arm.evaluations.iter().filter(|measured| !measured.evaluation.episodes.is_empty());
    let Some(first) = evaluated.next() else {
        return format!("**{name}** was not evaluated.");
    };
    let verdict = judge(arm, &first.evaluation);
    let mut text = format!(
        "**{name}** {}. In {}, {}",
        verdict.phrase(),
        first.evaluation.engine,
        evidence(arm, &first.evaluation, &verdict)
    );
    for measured in evaluated {
        text.push_str(&match conditions(arm, measured) {
            Some(_) => under(measured, &all_conditions(arm, measured).unwrap_or_default()),
            None => transfer(arm, first, measured),
        });
    }
    text
}

/// The result of the same policy in another evaluation.
fn transfer(arm: &Arm, first: &Measured, measured: &Measured) -> String {
    let evaluation = &measured.evaluation;
    let verdict = judge(arm, evaluation);
    let engine = &evaluation.engine;
    let place = if *engine == first.evaluation.engine {
        format!("In `{}`", measured.stage)
    } else {
        format!("In {engine}, {},", trained_there(arm, engine))
    };
    let varied = variations(arm, &measured.stage).map_or(String::new(), |words| format!(" ({words})"));
    format!(" {place}{varied} it {}: {}", verdict.phrase(), evidence(arm, evaluation, &verdict))
}

/// In which part of the training the engine was used. A fine-tuning may use another engine.
fn trained_there(arm: &Arm, engine: &str) -> &'static str {
    let is_this = |own: Option<EngineName>| own.is_some_and(|own| own.word() == engine);
    match (is_this(arm.section().at(Physics::engine)), is_this(arm.section().at(fine_tune::Ppo::engine))) {
        (_, true) => "where its training ended",
        (true, false) => "where its training began",
        (false, false) => "where it was not trained",
    }
}

/// The result of the same policy under conditions that its task does not require.
fn under(measured: &Measured, conditions: &str) -> String {
    let Measured { stage, evaluation } = measured;
    let share = |metric: &str| {
        let metric = Metric::named(metric).filter(|metric| metric.is_measured(evaluation))?;
        Some(with_interval(&metric.estimate(evaluation), true))
    };
    let survivors = evaluation.episodes.iter().filter(|episode| episode.survived).count();
    let (total, survival) = (evaluation.episodes.len(), share("survival").unwrap_or_default());
    let crossed =
        share("crossed").map_or(String::new(), |crossed| format!(" and crosses the obstacle in {crossed}"));
    let engine = &evaluation.engine;
    format!(
        " In `{stage}` ({conditions}; {engine}) it survives {survivors} of {total} episodes \
         ({survival}){crossed}."
    )
}

/// The numbers behind a verdict, and the criteria that are not met.
fn evidence(arm: &Arm, evaluation: &Evaluation, verdict: &Verdict) -> String {
    let survivors = evaluation.episodes.iter().filter(|episode| episode.survived).count();
    let total = evaluation.episodes.len();
    let estimate = |name: &str| {
        let metric = Metric::named(name).filter(|metric| metric.is_measured(evaluation))?;
        Some(with_interval(&metric.estimate(evaluation), true))
    };
    let mut parts = vec![format!(
        "it survives {survivors} of {total} episodes of {} s ({})",
        number(evaluation.time_limit),
        estimate("survival").unwrap_or_default()
    )];
    let part = |words: &str, name: &str| estimate(name).map(|text| format!("{words} {text}"));
    parts.extend(arm.task().and_then(|task| {
        let told = part(task.evidence.words, task.evidence.metric)?;
        let steady = task.evidence.second_half.map(|metric| {
            let steady = part(", in the second half", metric);
            steady.unwrap_or_else(|| ", and no episode reaches its second half".to_owned())
        });
        Some(told + &steady.unwrap_or_default())
    }));
    if arm.travels() {
        let asked = asked_speed(arm, evaluation)
            .map_or(String::new(), |speed| format!(" where {speed:.2} m/s was asked for"));
        parts.extend(estimate("speed").map(|text| format!("mean speed {text}{asked}")));
        parts.extend(part("speed error", "speed_error"));
    }
    let missed: Vec<&str> = verdict
        .criteria
        .iter()
        .filter(|criterion| !criterion.holds)
        .map(|criterion| criterion.text.as_str())
        .collect();
    let missed = if missed.is_empty() { String::new() } else { format!(" Not met: {}.", missed.join("; ")) };
    let unjudged =
        verdict.unjudged.as_ref().map_or(String::new(), |reason| format!(" Not judged: {reason}."));
    format!("{}.{missed}{unjudged}", parts.join("; "))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::Episode;
    use crate::spec::Value;

    #[test]
    fn a_standing_robot_is_not_said_to_walk() {
        let kind = BTreeMap::from([("kind".to_string(), Value::Text("walk".into()))]);
        let episode = Episode { survived: true, duration: 16.0, speed_error: 0.2, ..Episode::default() };
        let evaluation = Evaluation {
            engine: "rapier".into(),
            command: Some(0.2),
            time_limit: 16.0,
            episodes: vec![episode; 4],
            ..Evaluation::default()
        };
        let arm = Arm {
            name: "walk".into(),
            fields: BTreeMap::from([("task".to_string(), Value::Table(kind))]),
            evaluations: vec![Measured { stage: "evaluate.nominal".into(), evaluation }],
            ..Arm::default()
        };
        let text = &paragraphs(&ReportInput { arms: vec![arm], ..ReportInput::default() })[0];
        assert!(text.starts_with("**walk** does not walk. In rapier, it survives 4 of 4 episodes"), "{text}");
        assert!(text.contains("Not met: stands on the left foot alone"), "{text}");
    }

    #[test]
    fn an_engine_is_told_with_the_part_of_the_training_in_it() {
        let fields = |fine_tune: &str| {
            let engine =
                |name: &str| Value::Table(BTreeMap::from([("engine".to_string(), Value::Text(name.into()))]));
            BTreeMap::from([
                ("physics".to_string(), engine("mujoco")),
                ("fine_tune".to_string(), engine(fine_tune)),
            ])
        };
        let told = |fine_tune: &str, engine: &str| {
            trained_there(&Arm { fields: fields(fine_tune), ..Arm::default() }, engine)
        };
        assert_eq!(told("rapier", "mujoco"), "where its training began");
        assert_eq!(told("rapier", "rapier"), "where its training ended");
        assert_eq!(told("mujoco", "rapier"), "where it was not trained");
        assert_eq!(trained_there(&Arm::default(), "rapier"), "where it was not trained");
    }

    #[test]
    fn what_happens_under_other_conditions_is_told_with_them() {
        let at = |speed: f64| Episode {
            survived: true,
            command: Some(speed),
            crossed: Some(speed > 0.2),
            ..Episode::default()
        };
        let evaluation =
            Evaluation { engine: "rapier".into(), episodes: vec![at(0.1), at(0.3)], ..Evaluation::default() };
        let nominal = Evaluation { episodes: vec![Episode::default()], ..Evaluation::default() };
        let measured = |stage: &str, evaluation| Measured { stage: stage.into(), evaluation };
        let evaluations =
            vec![measured("evaluate.nominal", nominal), measured("evaluate.course", evaluation)];
        let arm = Arm { name: "walk".into(), evaluations, ..Arm::default() };
        let text = &paragraphs(&ReportInput { arms: vec![arm], ..ReportInput::default() })[0];
        let expected =
            "In `evaluate.course` (2 speeds from 0.1 to 0.3 m/s; rapier) it survives 2 of 2 episodes (100 %";
        assert!(text.contains(expected) && text.contains("and crosses the obstacle in 50 %"), "{text}");
    }
}
