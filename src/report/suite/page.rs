//! What the page of a suite has in place of the columns of single specs.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{changes, interval, table};
use crate::plan::Training;
use crate::report::failures;
use crate::report::group::{Group, groups, varying};
use crate::report::model::ReportInput;
use crate::report::table::{Tables, endings, health, with_rows};
use crate::report::tasks;
use crate::report::wording::arm_in_words;
use crate::statistics::summary::mean;

/// What only a suite has. Empty if the report is not on a suite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SuitePage {
    /// The axes on which the arms differ.
    pub axes: Vec<AxisPage>,
    /// Number of arms.
    pub arms: usize,
    /// Number of runs.
    pub runs: usize,
    /// The learning seeds; empty if each arm uses that of its spec.
    pub seeds: Vec<u64>,
    /// The name of the intervals over seeds.
    pub intervals: String,
    /// Caveats on the failures.
    pub failure_sentences: Vec<String>,
}

/// An axis of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxisPage {
    /// Its name.
    pub name: String,
    /// Its points.
    pub points: Vec<String>,
}

impl SuitePage {
    /// The variables of a suite's report.
    pub fn new(input: &ReportInput) -> Self {
        let Some(suite) = &input.suite else { return Self::default() };
        let groups = groups(input);
        let axes = varying(input, &groups);
        let axes = axes.into_iter().map(|(name, points)| AxisPage {
            name: name.to_owned(),
            points: points.into_iter().map(str::to_owned).collect(),
        });
        Self {
            axes: axes.collect(),
            arms: groups.len(),
            runs: input.arms.len(),
            seeds: suite.seeds.clone(),
            intervals: interval::over_seeds(&groups),
            failure_sentences: failures::told(&groups).1,
        }
    }
}

/// The tables of a suite's report, but for those of its claims and its cost.
pub fn tables(input: &ReportInput) -> Tables {
    let groups = groups(input);
    let axes: Vec<&str> = varying(input, &groups).iter().map(|(name, _)| *name).collect();
    let mut differences = table::differing(&groups, &axes);
    differences.push(changes::table(input, &groups));
    let mut evaluations = table::outcomes(&groups, &input.figures);
    evaluations.extend(table::interquartile(&groups, &input.figures));
    Tables {
        setup: table::shared(&groups),
        differences: with_rows(differences),
        learning: table::learning(&groups, Training::First),
        fine_tuning: table::learning(&groups, Training::FineTuning),
        health: health::of_groups(&groups),
        endings: endings::of_groups(&groups),
        evaluations: with_rows(evaluations),
        failures: failures::told(&groups).0,
        ..Tables::default()
    }
}

/// The result in short: the number of runs, and the arms with best and worst survival, in the first
/// evaluation and in those whose survival is the subject of a claim.
pub fn paragraphs(input: &ReportInput) -> Vec<String> {
    let groups = groups(input);
    let whole = input.arms.iter().filter(|arm| arm.failures.is_empty()).count();
    let (runs, arms) = (input.arms.len(), groups.len());
    let mut paragraphs = vec![if whole == runs {
        format!("All {runs} runs in {arms} arms are complete.")
    } else {
        format!("{whole} of {runs} runs in {arms} arms have all their results.")
    }];
    // This precedes all comparisons of arms, as those may compare failures.
    let records = tasks::records(input);
    for told in [tasks::unjudged_paragraph(&records), tasks::paragraph(&records)].into_iter().flatten() {
        paragraphs.insert(0, told);
    }
    let claims = input.suite.iter().flat_map(|suite| &suite.claims);
    let claimed: BTreeSet<&str> = claims
        .filter(|claim| claim.metric.name == "survival")
        .map(|claim| claim.metric.stage.as_str())
        .collect();
    let stages = table::stages(&groups).into_iter().enumerate();
    let told = stages.filter(|(at, stage)| *at == 0 || claimed.contains(stage.as_str()));
    let survivals: Vec<String> = told.filter_map(|(_, stage)| survivors(&groups, &stage)).collect();
    if !survivals.is_empty() {
        paragraphs.push(format!(
            "Survival, mean over seeds: {}. Survival alone says nothing about the task: a robot that stands \
             still survives.",
            survivals.join("; ")
        ));
    }
    paragraphs
}

/// The arms with worst and best survival in an evaluation.
fn survivors(groups: &[Group<'_>], stage: &str) -> Option<String> {
    let means = groups.iter().map(|group| (mean(&table::values(group, stage, "survival")), group.name));
    let mut ranked: Vec<(f64, &str)> = means.filter_map(|(mean, name)| Some((mean?, name))).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let ((most, best), (least, worst)) = (ranked.first()?, ranked.last()?);
    let [least, most] = [least, most].map(|share| format!("{:.0} %", 100.0 * share));
    Some(match ranked.len() {
        1 => format!("{most} in `{stage}`"),
        _ if least == most => format!("{most} in every arm in `{stage}`"),
        _ => {
            format!("from {least} ({}) to {most} ({}) in `{stage}`", arm_in_words(worst), arm_in_words(best))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::report::model::{Arm, Measured};

    /// A run that survives the given number of its four episodes in each evaluation.
    fn run(survived: &[(&str, usize)]) -> Arm {
        let measured = |(stage, count): &(&str, usize)| {
            let episode = |at| Episode { survived: at < *count, ..Episode::default() };
            let evaluation = Evaluation { episodes: (0..4).map(episode).collect(), ..Evaluation::default() };
            Measured { stage: (*stage).to_owned(), evaluation }
        };
        Arm { evaluations: survived.iter().map(measured).collect(), ..Arm::default() }
    }

    #[test]
    fn the_worst_and_the_best_arm_are_named_where_they_differ() {
        let (a, b) = (
            run(&[("evaluate.nominal", 4), ("evaluate.box", 1)]),
            run(&[("evaluate.nominal", 4), ("evaluate.box", 3)]),
        );
        let group = |name, run| Group { name, points: &[], runs: vec![run] };
        let groups = [group("a", &a), group("b", &b)];
        assert_eq!(
            survivors(&groups, "evaluate.nominal").unwrap(),
            "100 % in every arm in `evaluate.nominal`"
        );
        assert_eq!(
            survivors(&groups, "evaluate.box").unwrap(),
            "from 25 % (a) to 75 % (b) in `evaluate.box`"
        );
        assert_eq!(survivors(&groups[..1], "evaluate.box").unwrap(), "25 % in `evaluate.box`");
        assert_eq!(survivors(&groups, "evaluate.none"), None);
    }
}
