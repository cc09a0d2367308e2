//! The report of a suite: its arms, each summarised over its seeds.

pub mod changes;
pub mod interval;
pub mod page;
pub mod table;
pub mod tried;
pub mod warning;

use super::claim::{Judged, Observed, judge};
use super::group::{Group, groups};
use super::model::{Arm, ReportInput};

/// The claims of a suite with their verdicts.
pub fn judged(input: &ReportInput) -> Vec<Judged> {
    let Some(suite) = &input.suite else { return Vec::new() };
    let groups = groups(input);
    let runs: Vec<Vec<(u64, &Arm)>> = groups.iter().map(by_seed).collect();
    let observed: Vec<Observed> =
        groups.iter().zip(&runs).map(|(group, runs)| Observed { points: group.points, runs }).collect();
    judge(&suite.claims, &observed)
}

/// The runs of an arm with their seeds.
fn by_seed<'a>(group: &Group<'a>) -> Vec<(u64, &'a Arm)> {
    group.runs.iter().filter_map(|arm| Some((arm.run.as_ref()?.seed, *arm))).collect()
}
