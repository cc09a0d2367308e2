//! What a template sees of a suite beside the variables of every report.

use serde::{Deserialize, Serialize};

use super::{Group, failures, groups, table, varying};
use crate::plan::Training;
use crate::report::model::ReportInput;
use crate::report::table::{Table, endings, health};

/// A suite in a template. Without a suite everything is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SuitePage {
    /// The axes on which the arms differ.
    pub axes: Vec<AxisPage>,
    /// Number of arms.
    pub arms: usize,
    /// Number of runs.
    pub runs: usize,
    /// The learning seeds; empty when each arm has its spec's own.
    pub seeds: Vec<u64>,
    /// What all arms have in common.
    pub shared: Table,
    /// In what the arms differ.
    pub differing: Table,
    /// Learning, a row per arm.
    pub learning: Table,
    /// The same of the fine-tuning; without rows when no arm has one.
    pub fine_tuning: Table,
    /// What the run-time checks of the trainings found, a row per arm and code.
    pub health: Table,
    /// Why episodes ended in the last tenth of the training, a row per arm.
    pub endings: Table,
    /// What was evaluated: a table per evaluation, a row per arm, means over its seeds.
    pub outcomes: Vec<Table>,
    /// Interquartile means of the same, for arms of four seeds or more.
    pub interquartile: Vec<Table>,
    /// Evaluations over parameter sets: who survives, the arms on the same sets, why sets fail.
    pub failures: Vec<Table>,
    /// What must be known of the failures.
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
        let (failures, failure_sentences) = failures::told(&groups);
        let axes = varying(input, &groups).into_iter().map(|(name, points)| AxisPage {
            name: name.to_owned(),
            points: points.into_iter().map(str::to_owned).collect(),
        });
        Self {
            axes: axes.collect(),
            arms: groups.len(),
            runs: input.arms.len(),
            seeds: suite.seeds.clone(),
            shared: table::shared(&groups),
            differing: table::differing(&groups),
            learning: table::learning(&groups, Training::First),
            fine_tuning: table::learning(&groups, Training::FineTuning),
            health: health::of_groups(&groups),
            endings: endings::of_groups(&groups),
            outcomes: table::outcomes(&groups),
            interquartile: table::interquartile(&groups),
            failures,
            failure_sentences,
        }
    }

    /// Every table in the order of the report.
    pub fn tables(&self) -> Vec<&Table> {
        let Self { shared, differing, learning, fine_tuning, health, endings, .. } = self;
        let Self { outcomes, interquartile, failures, .. } = self;
        let mut tables = vec![shared, differing, learning, fine_tuning, health, endings];
        tables.extend(outcomes);
        tables.extend(interquartile);
        tables.extend(failures);
        tables
    }
}

/// The result in one paragraph: how many runs there are, and the arms that end best and worst.
pub fn paragraphs(input: &ReportInput) -> Vec<String> {
    let groups = groups(input);
    let whole = input.arms.iter().filter(|arm| arm.failures.is_empty()).count();
    let mut paragraphs =
        vec![format!("{whole} of {} runs in {} arms have all their results.", input.arms.len(), groups.len())];
    paragraphs.extend(ranked(&groups));
    paragraphs
}

/// The arms by mean survival in their first evaluation.
fn ranked(groups: &[Group<'_>]) -> Option<String> {
    let stage = table::stages(groups).into_iter().next()?;
    let survival = |group: &Group<'_>| {
        crate::report::statistics::summary::mean(&table::values(group, &stage, "survival"))
            .map(|mean| (mean, group.name.to_owned()))
    };
    let mut ranked: Vec<(f64, String)> = groups.iter().filter_map(survival).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (best, worst) = (ranked.first()?, ranked.last()?);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    if percent(best.0) == percent(worst.0) {
        return Some(format!("Survival in `{stage}`, mean over seeds: {} in every arm.", percent(best.0)));
    }
    Some(format!(
        "Survival in `{stage}`, mean over seeds: from {} (`{}`) to {} (`{}`). Survival alone says nothing of the task: a robot that stands still survives.",
        percent(worst.0),
        worst.1,
        percent(best.0),
        best.1
    ))
}
