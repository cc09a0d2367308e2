//! Why training episodes ended: the shares of the causes over the course of training.

use std::collections::BTreeMap;

/// The figure's name.
pub const ID: &str = "endings";

use super::Figure;
use crate::report::model::{Arm, ReportInput, Update};
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel};
use crate::report::source::sources;
use crate::report::wording::labels;

/// Most points along the horizontal axis; neighbouring updates are merged.
const POINTS: usize = 48;

/// The figure, if at least one arm recorded how episodes ended.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let arms: Vec<usize> =
        (0..input.arms.len()).filter(|arm| !causes([&input.arms[*arm]]).is_empty()).collect();
    if arms.is_empty() {
        return None;
    }
    let names = labels(&input.arms);
    let known = causes(&input.arms);
    let columns = arms.len().min(2);
    let rows = arms.len().div_ceil(columns);
    let mut drawing = Drawing::new(880.0, 230.0 * rows as f64 + 20.0, "Why training episodes ended");
    let gap = 170.0;
    let width = if columns == 1 { 640.0 } else { 700.0 };
    let grid = Area { left: 58.0, top: 34.0, width, height: 230.0 * rows as f64 - 66.0 };
    for (cell, arm) in arms.iter().enumerate() {
        let area = grid.cell([columns, rows], [cell % columns, cell / columns], [gap, 78.0]);
        panel(&mut drawing, &input.arms[*arm], area, &names[*arm], &known);
    }
    let total = |arm: &Arm| -> u64 { arm.updates.iter().flat_map(|update| update.ends.values()).sum() };
    let counts: Vec<String> = arms
        .iter()
        .map(|arm| format!("{}: n = {} episodes", names[*arm], total(&input.arms[*arm])))
        .collect();
    Some(Figure {
        id: ID.to_string(),
        title: "Why training episodes ended".to_string(),
        caption: format!("Share of the episodes that ended by each cause ({}).", counts.join("; ")),
        drawing,
        sources: sources(input, |arm| {
            arm.stage("learner").map(|_| "learner".to_string()).into_iter().collect()
        }),
    })
}

/// The causes that occurred, the time limit first (it is drawn at the bottom).
fn causes<'a>(arms: impl IntoIterator<Item = &'a Arm>) -> Vec<String> {
    let mut totals: BTreeMap<&str, u64> = BTreeMap::new();
    for (cause, count) in arms.into_iter().flat_map(|arm| &arm.updates).flat_map(|update| &update.ends) {
        *totals.entry(cause).or_default() += count;
    }
    let mut names: Vec<String> =
        totals.iter().filter(|(_, count)| **count > 0).map(|(name, _)| name.to_string()).collect();
    names.sort_by_key(|name| (name != "time_out", name.clone()));
    names
}

/// The panel of one arm; `known` are the causes in all arms, so that colours agree between panels.
fn panel(drawing: &mut Drawing, arm: &Arm, area: Area, name: &str, known: &[String]) {
    let causes = causes([arm]);
    let last = arm.updates.last().map_or(1.0, |update| update.samples as f64 / 1e6);
    let panel = Panel {
        area,
        x: Axis::over("samples (M)", [0.0, last.max(1e-6)], 6),
        y: Axis::over("share of episodes (%)", [0.0, 100.0], 5),
    };
    let points: Vec<(f64, Vec<f64>)> = shares(arm, &causes);
    panel.frame(drawing, name);
    let mut labels = Vec::new();
    for (index, cause) in causes.iter().enumerate() {
        let below = |shares: &[f64]| 100.0 * shares[..index].iter().sum::<f64>();
        let band: Vec<(f64, f64, f64)> = points
            .iter()
            .map(|(x, shares)| (*x, below(shares), below(shares) + 100.0 * shares[index]))
            .collect();
        let ink = ink(cause, known.iter().position(|other| other == cause).unwrap_or_default());
        panel.band(drawing, &band, ink, 0.75);
        labels.extend(band.last().map(|(_, low, high)| (0.5 * (low + high), cause.replace('_', " "), ink)));
    }
    panel.end_labels(drawing, &labels);
}

fn ink(cause: &str, index: usize) -> Ink {
    match (cause, index) {
        ("time_out", _) => Ink::Arm(2),
        (_, index) => [Ink::Arm(0), Ink::Arm(1), Ink::Arm(3), Ink::Arm(4), Ink::Arm(5)][index % 5],
    }
}

/// For each group of updates, the samples in millions and the shares of the causes.
fn shares(arm: &Arm, causes: &[String]) -> Vec<(f64, Vec<f64>)> {
    let group = arm.updates.len().div_ceil(POINTS).max(1);
    let of_group = |updates: &[Update]| {
        let count =
            |cause: &String| updates.iter().filter_map(|update| update.ends.get(cause)).sum::<u64>() as f64;
        let counts: Vec<f64> = causes.iter().map(count).collect();
        let total: f64 = counts.iter().sum();
        let middle = updates[updates.len() / 2].samples as f64 / 1e6;
        (total > 0.0).then(|| (middle, counts.iter().map(|count| count / total).collect()))
    };
    arm.updates.chunks(group).filter_map(of_group).collect()
}
