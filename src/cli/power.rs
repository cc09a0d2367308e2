//! `specforge plan --power SUITE`: what the tests of a suite's claims can decide, and how many seeds would
//! settle the open ones.

use super::{Exit, Format, Global, output};
use crate::escape::terminal::one_line;
use crate::plan::{Plan, RunRecord};
use crate::report::claim::{self, Judged, Planned, PlannedArm};
use crate::report::sidecar::Sidecar;
use crate::spec::Table;
use crate::study::Study;

/// Prints the tests of the claims and, from the latest report page, the open claims.
pub fn run(study: &Study, global: &Global) -> Exit {
    let Some(suite) = &study.plan.suite else {
        output::complain(
            global,
            "`--power` is about the claims of a suite",
            Some("name a suite, or leave `--power` out"),
        );
        return Exit::Usage;
    };
    let path = Sidecar::path(&study.reports(), &suite.name);
    let record =
        Sidecar::read_whole(&path).ok().filter(|record| !record.is_by_other_rules()).unwrap_or_default();
    if global.format == Format::Json {
        let observed = record.claims.iter().map(|judged| {
            serde_json::json!({ "id": judged.id, "verdict": judged.verdict,
                    "settled_by": judged.settled_by })
        });
        let answer = serde_json::json!({
            "suite": suite.name,
            "claims": planned(&study.plan),
            "observed": observed.collect::<Vec<_>>(),
        });
        output::json(&answer);
        return Exit::Ok;
    }
    let mut text = match table(&study.plan) {
        table if table.is_empty() => one_line("the suite has no claims"),
        table => table,
    };
    text += &observed(&record.claims);
    output::data(text.trim_end());
    Exit::Ok
}

/// The tests of a suite's claims.
fn planned(plan: &Plan) -> Vec<Planned> {
    let Some(suite) = &plan.suite else { return Vec::new() };
    let runs: Vec<&RunRecord> = plan.arms.iter().filter_map(|arm| arm.run.as_ref()).collect();
    let fields: Vec<(&str, Table)> = plan
        .arms
        .iter()
        .filter_map(|arm| Some((arm.run.as_ref()?.arm.as_str(), arm.fields.only(&["evaluate", "deploy"]))))
        .collect();
    let empty = Table::new();
    let arms: Vec<PlannedArm> = runs
        .chunk_by(|one, next| one.arm == next.arm)
        .map(|runs| {
            let own = fields.iter().find(|(arm, _)| *arm == runs[0].arm).map_or(&empty, |(_, fields)| fields);
            PlannedArm { points: &runs[0].points, seeds: runs.len(), fields: own }
        })
        .collect();
    claim::planned(&suite.claims, &arms)
}

/// The tests of a suite's claims as a table; empty without claims.
pub fn table(plan: &Plan) -> String {
    let planned = planned(plan);
    if planned.is_empty() {
        return String::new();
    }
    let heads = ["claim", "test", "n", "level", "detects", "power", "seeds for 80 %"].map(str::to_owned);
    let rows: Vec<[String; 7]> = [heads].into_iter().chain(planned.iter().map(Planned::cells)).collect();
    let width = |at: usize| rows.iter().map(|row| row[at].chars().count()).max().unwrap_or(0);
    let line = |row: &[String; 7]| {
        let cells: Vec<String> = (0..7).map(|at| format!("{:<width$}", row[at], width = width(at))).collect();
        one_line(cells.join("  ").trim_end())
    };
    let mut text: String = rows.iter().map(line).collect();
    if planned.iter().any(|planned| planned.unit == "run" && planned.detects.is_none()) {
        text += &one_line(
            "no `detects` or power: write the claim's expected `spread` and `effect`; trends and claims over \
             some, none or a number of comparisons have neither",
        );
    }
    text
}

/// The outcomes of the claims, and what would settle the open ones; empty without runs.
fn observed(judged: &[Judged]) -> String {
    let line = |judged: &Judged| {
        let settled = judged.settled_by.as_ref().map_or(String::new(), |settled| format!("; {settled}"));
        one_line(&format!("  {}: {}{settled}", judged.id, judged.verdict.word()))
    };
    let lines: String = judged.iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("\n{}{lines}", one_line("in the runs of the page")) }
}
