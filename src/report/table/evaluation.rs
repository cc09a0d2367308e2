//! Tables of the evaluations: metrics, criteria, differences between arms, rewards by term.

use std::collections::BTreeSet;

use super::conditions::{all_conditions, command, conditions};
use super::{Cell, Table};
use crate::kinds::task::Task;
use crate::report::comparison::{are_paired, differences};
use crate::report::estimate::Estimate;
use crate::report::metric::Metric;
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::source::Source;
use crate::report::verdict::judge;
use crate::report::wording::{labels, with_interval};

/// An evaluation with episodes and its arm.
pub struct Column<'a> {
    /// The evaluated arm.
    pub arm: &'a Arm,
    /// The evaluation and its stage.
    pub measured: &'a Measured,
    /// `torque, rapier, n = 32`.
    pub label: String,
}

impl Column<'_> {
    /// The stage that it is from.
    pub fn source(&self) -> Source {
        Source { arm: self.arm.name.clone(), stage: self.measured.stage.clone() }
    }
}

/// The evaluations with episodes, arm by arm.
pub fn columns(input: &ReportInput) -> Vec<Column<'_>> {
    let names = labels(&input.arms);
    let of_arm = |(arm, name): (&'_ Arm, &String)| -> Vec<(String, usize)> {
        let with_episodes =
            arm.evaluations.iter().enumerate().filter(|(_, one)| !one.evaluation.episodes.is_empty());
        with_episodes.map(|(index, measured)| (head(arm, measured, name), index)).collect()
    };
    let mut columns = Vec::new();
    for (arm, name) in input.arms.iter().zip(&names) {
        for (label, index) in of_arm((arm, name)) {
            columns.push(Column { arm, measured: &arm.evaluations[index], label });
        }
    }
    columns
}

/// `torque, rapier, n = 32`, with the stage if needed to tell columns apart.
fn head(arm: &Arm, measured: &Measured, name: &str) -> String {
    let evaluation = &measured.evaluation;
    format!("{name}, {}{}, n = {}", evaluation.engine, stage(arm, measured), evaluation.episodes.len())
}

/// ` (evaluate.box)` if an arm has several evaluations in that engine; empty if the engine identifies it.
fn stage(arm: &Arm, measured: &Measured) -> String {
    let twins =
        arm.evaluations.iter().filter(|other| other.evaluation.engine == measured.evaluation.engine).count();
    if twins > 1 { format!(" ({})", measured.stage) } else { String::new() }
}

/// A table with a column per evaluation.
fn table(id: &str, title: &str, columns: &[Column]) -> Table {
    let mut table = Table::new(
        id,
        title,
        [String::new()].into_iter().chain(columns.iter().map(|column| column.label.clone())),
    );
    table.sources = columns.iter().map(Column::source).collect();
    table.column_sources = (0..columns.len()).map(Some).collect();
    table
}

/// The metrics of every arm in every engine.
pub fn evaluation(input: &ReportInput) -> Table {
    let columns = columns(input);
    let mut table = table("evaluation", "Evaluation", &columns);
    let told: Vec<Option<String>> =
        columns.iter().map(|column| all_conditions(column.arm, column.measured)).collect();
    if told.iter().any(Option::is_some) {
        let usual = |column: &Column| command(&column.measured.evaluation);
        let cells = told.into_iter().zip(&columns);
        table.row(
            "",
            "conditions",
            cells.map(|(told, column)| Cell::Text(told.unwrap_or_else(|| usual(column)))),
        );
    }
    for metric in Metric::tabled() {
        let suits = |column: &Column| {
            metric.suits(column.arm.kind::<Task>()) && metric.is_measured(&column.measured.evaluation)
        };
        if !columns.iter().any(suits) {
            continue;
        }
        let cell = |column: &Column| -> Cell {
            if suits(column) {
                metric.estimate(&column.measured.evaluation).into()
            } else {
                "\u{2013}".into()
            }
        };
        let unit = if metric.unit.is_empty() { String::new() } else { format!(" ({})", metric.unit) };
        let partly = |column: &Column| suits(column) && metric.without(&column.measured.evaluation) > 0;
        let zeros = if columns.iter().any(partly) { ", 0 for an episode that ended before" } else { "" };
        table.row(metric.name, &format!("{}{zeros}{unit}", metric.label), columns.iter().map(cell));
    }
    table
}

/// Reward per second by term, with the sum.
pub fn reward(input: &ReportInput) -> Table {
    let columns = columns(input);
    let mut table = table("reward", "Reward per second by term", &columns);
    let episodes = columns.iter().flat_map(|column| &column.measured.evaluation.episodes);
    let terms: BTreeSet<&String> = episodes.flat_map(|episode| episode.reward_per_second.keys()).collect();
    if terms.is_empty() {
        return table;
    }
    for term in &terms {
        let cells =
            columns.iter().map(|column| reward_mean(column, term, |reward| reward.get(*term).copied()));
        table.row(term, &format!("`{term}`"), cells.collect::<Vec<_>>());
    }
    let sums = columns.iter().map(|column| reward_mean(column, "sum", |reward| Some(reward.values().sum())));
    table.row("sum", "sum", sums.collect::<Vec<_>>());
    table
}

fn reward_mean(
    column: &Column,
    term: &str,
    of: impl Fn(&std::collections::BTreeMap<String, f64>) -> Option<f64>,
) -> Cell {
    let episodes = &column.measured.evaluation.episodes;
    let values: Vec<f64> = episodes.iter().filter_map(|episode| of(&episode.reward_per_second)).collect();
    Estimate::mean(&values, "", 1, &format!("reward/{term}")).into()
}

/// The criteria of the task and whether each arm meets them in each engine. Evaluations under other
/// conditions than the task's are omitted if there are others.
pub fn criteria(input: &ReportInput) -> Table {
    let mut columns = columns(input);
    let asked = |column: &Column| conditions(column.arm, column.measured).is_none();
    if columns.iter().any(asked) {
        columns.retain(asked);
    }
    let heads = ["", "criterion", "measured", "met"].map(String::from);
    let mut table = Table::new("criteria", "Does it do the task?", heads);
    table.sources = self::table("", "", &columns).sources;
    for column in &columns {
        for criterion in judge(column.arm, &column.measured.evaluation).criteria {
            let met = criterion.met();
            table.row(
                "",
                &column.label,
                [
                    Cell::Text(criterion.text),
                    Cell::Text(with_interval(&criterion.measured, true)),
                    Cell::Text(met),
                ],
            );
        }
    }
    table
}

/// The first arm compared with each other arm, in every engine used for both: one table per pair.
pub fn comparisons(input: &ReportInput) -> Vec<Table> {
    let names = labels(&input.arms);
    let Some(first) = input.arms.first() else { return Vec::new() };
    let mut tables = Vec::new();
    for (place, other) in input.arms.iter().enumerate().skip(1) {
        for measured in &first.evaluations {
            let Some(twin) = other.evaluations.iter().find(|twin| twin.is_the_same_as(measured)) else {
                continue;
            };
            tables.extend(comparison([first, other], [measured, twin], [&names[0], &names[place]]));
        }
    }
    tables
}

fn comparison(arms: [&Arm; 2], [a, b]: [&Measured; 2], names: [&str; 2]) -> Option<Table> {
    let (one, two) = (&a.evaluation, &b.evaluation);
    let (engine, pairing) =
        (&one.engine, if are_paired(one, two) { "paired episodes" } else { "independent episodes" });
    let n = one.episodes.len().min(two.episodes.len());
    let title =
        format!("{} minus {} in {engine}{} ({pairing}, n = {n})", names[0], names[1], stage(arms[0], a));
    let heads = ["", "difference", "zero lies outside the interval"].map(String::from);
    let own =
        if stage(arms[0], a).is_empty() { String::new() } else { format!("_{}", a.stage.replace('.', "_")) };
    let mut table = Table::new(&format!("comparison_{}_{engine}{own}", names[1]), &title, heads);
    for difference in differences(one, two, arms[0].kind::<Task>()) {
        let p = difference.p.map_or(String::new(), |p| format!(", exact test p {}", significance(p)));
        let verdict = format!("{}{p}", if difference.established { "yes" } else { "no" });
        let unit = match difference.difference.unit.as_str() {
            "" => String::new(),
            "%" => " (points)".to_string(),
            unit => format!(" ({unit})"),
        };
        let label = format!("{}{unit}", difference.label);
        table.row(&difference.metric, &label, [difference.difference.into(), Cell::Text(verdict)]);
    }
    table.sources =
        (0..2).map(|side| Source { arm: arms[side].name.clone(), stage: a.stage.clone() }).collect();
    (!table.rows.is_empty()).then_some(table)
}

/// A p value in few digits.
fn significance(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_string() } else { format!("= {p:.3}") }
}
