//! The answer of a report in a few sentences, for its first lines.

use super::claim::{Judged, Ruling, count};
use super::comparison::differences;
use super::metric::Metric;
use super::model::{Arm, Measured, ReportInput};
use super::table::conditions::conditions;
use super::verdict::judge;
use super::wording::{labels, listed, with_interval};
use crate::kinds::task::Task;

/// Most claims of a verdict whose text is quoted; the table below the answer has all.
const TOLD: usize = 3;
/// With more claims than this, one of each verdict is quoted.
const MANY: usize = 10;

/// What the claims of a suite came to: how many are established, and the texts of the first that are
/// established, refuted and open.
pub fn of_claims(judged: &[Judged]) -> String {
    let texts = |rulings: &[Ruling]| -> Vec<String> {
        let those = judged.iter().filter(|claim| rulings.contains(&claim.verdict));
        those.map(|claim| claim.text.trim_end_matches('.').to_owned()).collect()
    };
    let kinds = [
        ("Established", texts(&[Ruling::Pass])),
        ("Refuted", texts(&[Ruling::Fail])),
        ("Open", texts(&[Ruling::NotEstablished, Ruling::NotMeaningful])),
    ];
    let most = if judged.len() > MANY { 1 } else { TOLD };
    let told = kinds.into_iter().filter(|(_, texts)| !texts.is_empty()).map(|(word, texts)| {
        let more = texts.len().saturating_sub(most);
        let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
        format!(" {word}: {}{rest}.", texts[..texts.len() - more].join("; "))
    });
    count(judged) + &told.collect::<String>()
}

/// Which arms do their task in which engines, and how the first differs from the others.
pub fn of_arms(input: &ReportInput) -> String {
    let names = labels(&input.arms);
    let done: Vec<String> = input.arms.iter().zip(&names).map(|(arm, name)| does(arm, name)).collect();
    let mut sentences = vec![format!("{}.", done.join("; "))];
    if let [first, others @ ..] = input.arms.as_slice() {
        let compared = others.iter().zip(&names[1..]);
        sentences.extend(compared.filter_map(|(other, name)| difference([first, other], [&names[0], name])));
    }
    sentences.join(" ")
}

/// The evaluations under the conditions of the arm's own task; if each has other conditions, the first one.
fn own(arm: &Arm) -> Vec<&Measured> {
    let evaluated = || arm.evaluations.iter().filter(|measured| !measured.evaluation.episodes.is_empty());
    let own: Vec<&Measured> = evaluated().filter(|measured| conditions(arm, measured).is_none()).collect();
    if own.is_empty() { evaluated().take(1).collect() } else { own }
}

/// `torque runs in batch, mujoco and rapier`, `position runs in batch, but not in rapier`.
fn does(arm: &Arm, name: &str) -> String {
    let verdicts: Vec<_> =
        own(arm).into_iter().map(|measured| (measured, judge(arm, &measured.evaluation))).collect();
    let Some((_, first)) = verdicts.first() else { return format!("**{name}** was not evaluated") };
    let engines = |wanted: &dyn Fn(&super::verdict::Verdict) -> bool| -> Vec<String> {
        let those = verdicts.iter().filter(|(_, verdict)| wanted(verdict));
        let mut engines: Vec<String> =
            those.map(|(measured, _)| measured.evaluation.engine.clone()).collect();
        engines.dedup();
        engines
    };
    let [does, fails, unjudged] = [
        engines(&|verdict| verdict.holds),
        engines(&|verdict| !verdict.holds && verdict.unjudged.is_none()),
        engines(&|verdict| verdict.unjudged.is_some()),
    ];
    let stem = first.verb.strip_suffix('s').unwrap_or(&first.verb);
    let open = match unjudged.as_slice() {
        [] => String::new(),
        engines => format!(", and is not judged in {}", listed(engines)),
    };
    match (does.is_empty(), fails.is_empty()) {
        (true, true) => format!("**{name}** is not judged in {}", listed(&unjudged)),
        (false, true) => format!("**{name} {}** in {}{open}", first.verb, listed(&does)),
        (true, false) => format!("**{name} does not {stem}** in {}{open}", listed(&fails)),
        (false, false) => {
            format!("**{name} {}** in {}, but not in {}{open}", first.verb, listed(&does), listed(&fails))
        }
    }
}

/// The first arm against another, by the metric that matters most for the task, in the first engine of both.
fn difference(arms: [&Arm; 2], names: [&str; 2]) -> Option<String> {
    let metric = if arms[0].travels() { "speed_error" } else { arms[0].task()?.evidence.metric };
    let measured = own(arms[0]).into_iter().next()?;
    let twin = own(arms[1]).into_iter().find(|twin| twin.is_the_same_as(measured))?;
    let found = differences(&measured.evaluation, &twin.evaluation, arms[0].kind::<Task>());
    let found = found.into_iter().find(|difference| difference.metric == metric)?;
    let metric = Metric::named(metric)?;
    let [one, two] = [measured, twin].map(|side| with_interval(&metric.estimate(&side.evaluation), true));
    let (engine, label) = (&measured.evaluation.engine, found.label);
    let [a, b] = names;
    Some(match (found.established, found.difference.value? > 0.0) {
        (true, larger) => {
            let than = if larger { "larger" } else { "smaller" };
            format!(
                "In {engine} the {label} of {a} is {than} than that of {b}: {one} against {two}, \
                 one seed each, so this may be chance."
            )
        }
        (false, _) => {
            format!(
                "In {engine} no difference of {a} and {b} in the {label} is established: {one} and {two}, \
                 one seed each."
            )
        }
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::spec::Value;

    #[test]
    fn claims_that_are_established_refuted_and_open_are_told_in_this_order() {
        let claim = |text: &str, verdict| Judged { text: text.into(), verdict, ..Judged::default() };
        let mut claims = vec![claim("It walks.", Ruling::Pass)];
        assert!(of_claims(&claims).ends_with(" Established: It walks."), "{}", of_claims(&claims));
        claims.push(claim("It runs", Ruling::NotEstablished));
        assert!(of_claims(&claims).ends_with(" Open: It runs."));
        claims.extend(["A", "B", "C", "D"].map(|text| claim(text, Ruling::Fail)));
        let told = " Established: It walks. Refuted: A; B; C; and 1 more. Open: It runs.";
        assert!(of_claims(&claims).ends_with(told), "{}", of_claims(&claims));
        claims.extend(["E", "F", "G", "H", "I"].map(|text| claim(text, Ruling::Pass)));
        let told = " Established: It walks; and 5 more. Refuted: A; and 3 more. Open: It runs.";
        assert!(of_claims(&claims).ends_with(told), "{}", of_claims(&claims));
    }

    /// An arm that squats, and whose joints stay so far from its reference in each engine.
    fn arm(name: &str, errors: [f64; 2]) -> Arm {
        let measured = |(engine, error): (&str, f64)| {
            let episode = |at: u64| Episode {
                survived: true,
                tracking_error: [error, 0.0],
                stream: at.to_string(),
                ..Episode::default()
            };
            let episodes = (0..8).map(episode).collect();
            let evaluation = Evaluation { engine: engine.into(), episodes, ..Evaluation::default() };
            Measured { stage: format!("evaluate.{engine}"), evaluation }
        };
        let kind = BTreeMap::from([("kind".to_owned(), Value::Text("squat".into()))]);
        Arm {
            name: name.into(),
            fields: BTreeMap::from([("task".to_owned(), Value::Table(kind))]),
            evaluations: ["batch", "rapier"].into_iter().zip(errors).map(measured).collect(),
            ..Arm::default()
        }
    }

    #[test]
    fn the_engines_in_which_an_arm_fails_are_named_and_the_first_arm_is_compared_with_the_others() {
        let arms = vec![arm("squat_torque", [0.1, 0.6]), arm("squat_position", [0.2, 0.2])];
        let text = of_arms(&ReportInput { arms, ..ReportInput::default() });
        assert!(
            text.starts_with(
                "**torque squats** in batch, but not in rapier; **position squats** in batch and rapier."
            ),
            "{text}"
        );
        assert!(text.contains("of torque is smaller than that of position: 0.100 rad"), "{text}");
        let alone = of_arms(&ReportInput { arms: vec![arm("squat", [0.1, 0.1])], ..ReportInput::default() });
        assert_eq!(alone, "**squat squats** in batch and rapier.");
        let none = of_arms(&ReportInput {
            arms: vec![Arm { name: "it".into(), ..Arm::default() }],
            ..ReportInput::default()
        });
        assert_eq!(none, "**it** was not evaluated.");
    }
}
