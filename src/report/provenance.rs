//! Provenance and cost: the stages, and the figures and tables made from them.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::estimate::Estimate;
use crate::report::figure::Figure;
use crate::report::model::{ReportInput, StageRecord};
use crate::report::source::Source;
use crate::report::table::{Cell, Table};
use crate::report::wording::{commit, labels, short};

/// The stages of all arms: fingerprint, version, cost. A stage shared by arms is listed once.
pub fn stages(input: &ReportInput) -> Table {
    let heads = ["stage", "arm", "fingerprint", "specforge", "commit", "ended"].map(String::from);
    let mut table = Table::new("stages", "Stages", heads);
    for (record, arms) in distinct(input) {
        let version = if record.tool_version.is_empty() { "\u{2013}" } else { &record.tool_version };
        let built = if record.commit.is_empty() {
            "\u{2013}".to_string()
        } else {
            format!("`{}`", commit(&record.commit))
        };
        let ended = if record.finished.is_empty() { "\u{2013}" } else { &record.finished };
        let fingerprint = format!("`{}`", short(&record.fingerprint));
        table.row(
            "",
            &record.stage,
            [Cell::Text(arms), fingerprint.into(), version.into(), built.into(), ended.into()],
        );
    }
    table
}

/// Wall and CPU time of the stages that were run, with the sum.
pub fn cost(input: &ReportInput) -> Table {
    let heads = ["stage", "arm", "wall (s)", "CPU (s)"].map(String::from);
    let mut table = Table::new("cost", "Cost", heads);
    let records = distinct(input);
    for (record, arms) in records.iter().filter(|(record, _)| record.wall_s >= 0.05) {
        let times = [record.wall_s, record.cpu_s].map(|time| Cell::from(Estimate::exact(time, "s", 1)));
        table.row("", &record.stage, [Cell::Text(arms.clone())].into_iter().chain(times));
    }
    let sum = |of: fn(&StageRecord) -> f64| -> Cell {
        Estimate::exact(records.iter().map(|(record, _)| of(record)).sum(), "s", 1).into()
    };
    table.row(
        "",
        "all stages, one after another",
        [Cell::from(""), sum(|record| record.wall_s), sum(|record| record.cpu_s)],
    );
    table
}

/// Wall and CPU time by stage name, with the sum: the cost of a suite.
pub fn sum(input: &ReportInput) -> Table {
    let heads = ["stage", "stages", "wall (s)", "CPU (s)"].map(String::from);
    let mut table = Table::new("cost", "Cost", heads);
    let mut known = BTreeSet::new();
    let records =
        input.arms.iter().flat_map(|arm| &arm.stages).filter(|record| known.insert(&record.fingerprint));
    let mut sums: BTreeMap<&str, (usize, f64, f64)> = BTreeMap::new();
    for record in records {
        let (count, wall, cpu) = sums.entry(&record.stage).or_default();
        (*count, *wall, *cpu) = (*count + 1, *wall + record.wall_s, *cpu + record.cpu_s);
    }
    let total = sums.values().fold((0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
    sums.insert("all", total);
    for (stage, (count, wall, cpu)) in sums {
        let times = [wall, cpu].map(|time| Cell::from(Estimate::exact(time, "s", 1)));
        table.row("", stage, [Cell::Text(count.to_string())].into_iter().chain(times));
    }
    table
}

/// Every figure and table with the stages it is made from.
pub fn items(input: &ReportInput, figures: &[Figure], tables: &[&Table]) -> Table {
    let heads = ["figure or table", "stages", "spec fields"].map(String::from);
    let mut table = Table::new("provenance", "Figures and tables", heads);
    for (id, sources) in figures
        .iter()
        .map(|figure| (&figure.id, &figure.sources))
        .chain(tables.iter().map(|table| (&table.id, &table.sources)))
        .filter(|(_, sources)| !sources.is_empty())
    {
        table.row(
            "",
            &format!("`{id}`"),
            [stages_of(input, sources), fields_of(input, sources)].map(Cell::Text),
        );
    }
    table
}

/// `learner torque 0123456789, learner position ...`.
fn stages_of(input: &ReportInput, sources: &[Source]) -> String {
    let names = labels(&input.arms);
    let describe = |source: &Source| {
        let place = input.arms.iter().position(|arm| arm.name == source.arm)?;
        let record = input.arms[place].stage(&source.stage);
        let fingerprint = record.map_or(String::new(), |record| format!(" `{}`", short(&record.fingerprint)));
        Some(format!("{} {}{fingerprint}", names[place], source.stage))
    };
    sources.iter().filter_map(describe).collect::<Vec<_>>().join("<br>")
}

fn fields_of(input: &ReportInput, sources: &[Source]) -> String {
    let record = |source: &Source| input.arms.iter().find(|arm| arm.name == source.arm)?.stage(&source.stage);
    let fields: BTreeSet<&String> =
        sources.iter().filter_map(record).flat_map(|record| &record.fields).collect();
    fields.iter().map(|field| format!("`{field}`")).collect::<Vec<_>>().join(", ")
}

/// The stages in order, each fingerprint once, with the arms that use it.
fn distinct(input: &ReportInput) -> Vec<(&StageRecord, String)> {
    let names = labels(&input.arms);
    let mut rows: Vec<(&StageRecord, Vec<&str>)> = Vec::new();
    for (arm, name) in input.arms.iter().zip(&names) {
        for record in &arm.stages {
            match rows
                .iter_mut()
                .find(|(known, _)| known.fingerprint == record.fingerprint && known.stage == record.stage)
            {
                Some((_, arms)) => arms.push(name),
                None => rows.push((record, vec![name])),
            }
        }
    }
    rows.into_iter().map(|(record, arms)| (record, arms.join(", "))).collect()
}
