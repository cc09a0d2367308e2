//! Findings of the run-time checks during training, with start and duration.

use super::{Cell, Table};
use crate::learn::finding::{Finding, cure};
use crate::report::group::Group;
use crate::report::model::{Arm, ReportInput};
use crate::report::source::Source;
use crate::report::wording::{arm_in_words, count, labels};

/// The table of findings, one row each; may be empty.
pub fn health(input: &ReportInput) -> Table {
    let heads = ["warning", "what", "from (samples)", "to (samples)", "first thing to try"].map(String::from);
    let mut table =
        Table::new("health", "Warnings of the training", ["arm".to_owned()].into_iter().chain(heads));
    for (arm, name) in input.arms.iter().zip(labels(&input.arms)) {
        for finding in shown(arm) {
            let until = finding.until.map_or_else(|| "the end".to_owned(), count);
            let cells = [coded(&finding.code), finding.message.clone(), count(finding.since), until];
            let advice = cure(&finding.code).to_owned();
            table.row("", &name, cells.into_iter().chain([advice]).map(Cell::Text));
        }
    }
    table.sources = sources(input.arms.iter());
    table
}

/// The findings of a suite, one row per arm and code.
pub fn of_groups(groups: &[Group<'_>]) -> Table {
    let heads =
        ["arm", "warning", "runs", "what, in the first of them", "from (samples)", "first thing to try"];
    let mut table = Table::new("health", "Warnings of the trainings", heads.map(String::from));
    for group in groups {
        let mut found: Vec<&Finding> = group.runs.iter().flat_map(|run| shown(run)).collect();
        found.sort_by(|a, b| a.code.cmp(&b.code));
        for same in found.chunk_by(|a, b| a.code == b.code) {
            let code = &same[0].code;
            let runs =
                group.runs.iter().filter(|run| shown(run).any(|finding| finding.code == *code)).count();
            let earliest = same.iter().map(|finding| finding.since).min().unwrap_or(0);
            let cells = [
                coded(code),
                format!("{runs} of {}", group.runs.len()),
                same[0].message.clone(),
                count(earliest),
                cure(code).to_owned(),
            ];
            table.row("", &arm_in_words(group.name), cells.map(Cell::Text));
        }
    }
    table.sources = sources(groups.iter().flat_map(|group| group.runs.iter().copied()));
    table
}

/// Remarks on the table: no findings, allowed findings, and arms that were not checked.
pub fn sentences(input: &ReportInput) -> Vec<String> {
    let learned: Vec<(&Arm, String)> =
        input.arms.iter().zip(labels(&input.arms)).filter(|(arm, _)| !arm.updates.is_empty()).collect();
    let mut sentences = Vec::new();
    let checked = learned.iter().filter(|(arm, _)| arm.findings.is_some()).count();
    if checked > 0 && learned.iter().all(|(arm, _)| shown(arm).next().is_none()) {
        sentences.push("The run-time checks of the training found nothing to warn of.".to_owned());
    }
    for (arm, name) in &learned {
        for (code, reason) in &arm.allow {
            if arm.findings.iter().flatten().any(|finding| finding.code == *code) {
                sentences
                    .push(format!("{name}: {} was found and is allowed by the spec: {reason}.", coded(code)));
            }
        }
        if arm.findings.is_none() {
            sentences.push(format!("{name}: trained by a version without run-time checks."));
        }
    }
    sentences
}

/// The findings that the spec does not allow.
pub fn shown(arm: &Arm) -> impl Iterator<Item = &Finding> {
    arm.findings.iter().flatten().filter(|finding| !arm.allow.contains_key(&finding.code))
}

fn coded(code: &str) -> String {
    format!("`{code}`")
}

fn sources<'a>(arms: impl Iterator<Item = &'a Arm>) -> Vec<Source> {
    let learned = arms.filter(|arm| arm.stage("learner").is_some());
    learned.map(|arm| Source { arm: arm.name.clone(), stage: "learner".into() }).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::report::model::Update;

    fn arm(findings: Option<Vec<Finding>>) -> Arm {
        Arm { name: "walk".into(), findings, updates: vec![Update::default()], ..Arm::default() }
    }

    fn finding(code: &str) -> Finding {
        let message = "the policy jumps".to_owned();
        Finding { code: code.into(), message, since: 8192, until: Some(16_384), ..Finding::default() }
    }

    fn input(arms: Vec<Arm>) -> ReportInput {
        ReportInput { arms, ..ReportInput::default() }
    }

    #[test]
    fn a_finding_is_told_with_its_samples_and_one_that_is_allowed_with_its_reason() {
        let mut found = arm(Some(vec![finding("W0601"), finding("W0606")]));
        let table = health(&input(vec![found.clone()]));
        let cells = ["`W0601`", "the policy jumps", "8192", "16 384", cure("W0601")].map(Cell::from);
        assert_eq!((table.rows.len(), &table.rows[0].cells), (2, &cells.to_vec()));
        found.allow = BTreeMap::from([("W0606".to_owned(), "it only stands".to_owned())]);
        let input = input(vec![found]);
        assert_eq!(health(&input).rows.len(), 1);
        assert_eq!(
            sentences(&input),
            ["walk: `W0606` was found and is allowed by the spec: it only stands."]
        );
    }

    #[test]
    fn nothing_found_is_said_and_so_is_an_unchecked_training() {
        let nothing = "The run-time checks of the training found nothing to warn of.";
        assert_eq!(sentences(&input(vec![arm(Some(Vec::new()))])), [nothing]);
        assert_eq!(
            sentences(&input(vec![arm(None)])),
            ["walk: trained by a version without run-time checks."]
        );
        let none = Arm { updates: Vec::new(), ..arm(Some(Vec::new())) };
        assert!(sentences(&input(vec![none])).is_empty(), "nothing was trained");
    }

    #[test]
    fn a_suite_counts_the_runs_of_an_arm() {
        let (one, two) =
            (arm(Some(vec![finding("W0601")])), arm(Some(vec![finding("W0601"), finding("W0607")])));
        let well = arm(Some(Vec::new()));
        let table = of_groups(&[Group { name: "std=5 %", points: &[], runs: vec![&well, &one, &two] }]);
        let runs: Vec<&Cell> = table.rows.iter().map(|row| &row.cells[1]).collect();
        assert_eq!(runs, [&Cell::from("2 of 3"), &Cell::from("1 of 3")]);
    }
}
