//! The question that a report answers.

use super::model::ReportInput;
use super::wording::{capitalised, labels, listed};

/// The question in the spec; else a suite's summary, which is one ("Which robots walk, and how fast"), or a
/// question about the arms' task.
pub fn question(input: &ReportInput) -> String {
    let own = match (input.question.as_str(), &input.suite) {
        ("", Some(_)) => &input.summary,
        _ => &input.question,
    };
    match own.as_str() {
        "" => of_task(input),
        text => format!("{}?", capitalised(text.trim_end_matches(['.', '?']))),
    }
}

/// `Does tocabi_walk_torque walk?`, `Which of torque and position runs, and which runs better?`.
fn of_task(input: &ReportInput) -> String {
    let verb = input.arms.first().and_then(|arm| arm.task()).map_or("stands", |task| task.verb);
    let stem = verb.strip_suffix('s').unwrap_or(verb);
    match labels(&input.arms).as_slice() {
        [] => "What was measured?".to_owned(),
        [one] => format!("Does {one} {stem}?"),
        several => format!("Which of {} {verb}, and which {verb} better?", listed(several)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SuiteRecord;
    use crate::report::model::Arm;

    fn asked(own: &str, summary: &str, names: &[&str], suite: bool) -> String {
        let arms = names.iter().map(|name| Arm { name: (*name).into(), ..Arm::default() }).collect();
        let suite = suite.then(SuiteRecord::default);
        question(&ReportInput {
            question: own.into(),
            summary: summary.into(),
            arms,
            suite,
            ..ReportInput::default()
        })
    }

    #[test]
    fn a_question_is_the_specs_own_or_its_summary_or_made_of_its_arms() {
        assert_eq!(asked("does it walk?", "It walks", &["a_b"], false), "Does it walk?");
        assert_eq!(
            asked("", "Which robots walk, and how fast", &["a"], true),
            "Which robots walk, and how fast?"
        );
        assert_eq!(asked("", "It walks", &["a_b"], false), "Does a_b stand?");
        let of_two = "Which of torque and position stands, and which stands better?";
        assert_eq!(asked("", "", &["walk_torque", "walk_position"], false), of_two);
    }
}
