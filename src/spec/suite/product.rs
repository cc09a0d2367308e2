//! The combinations of a sweep: axes multiply in the order of the file, zipped axes advance together, and
//! patterns select.

use super::limit::MOST;
use super::{Pattern, Sweep};
use crate::diag::{Diagnostic, Sink};

/// One combination: the index of a point for each axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// By axis.
    pub points: Vec<usize>,
    /// For each axis, whether no other cell differs from this one in that axis only.
    pub alone: Vec<bool>,
}

impl Sweep {
    /// All selected combinations. E0703 if the selection is empty.
    pub fn cells(&self, sink: &mut Sink) -> Vec<Cell> {
        let groups = self.groups();
        let count =
            groups.iter().try_fold(1_usize, |all, group| all.checked_mul(self.axes[group[0]].points.len()));
        // Counted before any is created.
        if count.is_none_or(|count| count > MOST) {
            let error = Diagnostic::error("E0204", format!("the sweep has more than {MOST} combinations"));
            sink.emit(error.at(self.place, "all its axes multiplied").help("split the suite"));
            return Vec::new();
        }
        let mut all: Vec<Vec<usize>> = vec![vec![0; self.axes.len()]];
        for group in &groups {
            let points = 0..self.axes[group[0]].points.len();
            let with = |cell: &Vec<usize>, point: usize| {
                let mut cell = cell.clone();
                group.iter().for_each(|axis| cell[*axis] = point);
                cell
            };
            all = all.iter().flat_map(|cell| points.clone().map(move |point| with(cell, point))).collect();
        }
        all.retain(|cell| self.takes(cell));
        if all.is_empty() {
            let error =
                Diagnostic::error("E0703", "the sweep is empty").at(self.place, "no combination is left");
            sink.emit(error.help("relax `include` or `exclude`"));
        }
        let seeds = self.seeds.as_ref().map_or(1, Vec::len);
        if all.len() * seeds > MOST {
            let message =
                format!("the sweep has {} runs: {} arms, {seeds} seeds each", all.len() * seeds, all.len());
            let error = Diagnostic::error("E0204", message).at(self.place, format!("at most {MOST}"));
            sink.emit(error.help("choose fewer seeds or points, or make several suites of it"));
            return Vec::new();
        }
        let alone = (0..self.axes.len()).map(|axis| lonely(&all, axis)).collect::<Vec<_>>();
        let cell = |(at, points)| Cell { points, alone: alone.iter().map(|axis| axis[at]).collect() };
        all.into_iter().enumerate().map(cell).collect()
    }

    /// The groups of axes that vary together, in the order of the file; most have one axis.
    fn groups(&self) -> Vec<Vec<usize>> {
        let zipped = |axis: usize| self.zips.iter().find(|group| group.contains(&axis));
        let first = |axis: &usize| zipped(*axis).is_none_or(|group| group.iter().min() == Some(axis));
        (0..self.axes.len())
            .filter(first)
            .map(|axis| zipped(axis).cloned().unwrap_or_else(|| vec![axis]))
            .collect()
    }

    fn takes(&self, cell: &[usize]) -> bool {
        let named = self.named(cell);
        let included = self.include.is_empty() || self.include.iter().any(|pattern| pattern.matches(&named));
        let excluded = |pattern: &Pattern| pattern.seeds.is_empty() && pattern.matches(&named);
        let has_seeds = self.seeds_of(&named).is_none_or(|seeds| !seeds.is_empty());
        included && has_seeds && !self.exclude.iter().any(excluded)
    }

    /// Axis and point of a combination, by name.
    pub fn named(&self, cell: &[usize]) -> Vec<(String, String)> {
        let name =
            |(axis, point): (&super::Axis, &usize)| (axis.name.clone(), axis.points[*point].name.clone());
        self.axes.iter().zip(cell).map(name).collect()
    }
}

/// For each combination, whether it is the only one with its points on the other axes.
fn lonely(cells: &[Vec<usize>], axis: usize) -> Vec<bool> {
    let without = |cell: &Vec<usize>| {
        let mut rest = cell.clone();
        rest[axis] = 0;
        rest
    };
    let mut counts = std::collections::BTreeMap::<Vec<usize>, usize>::new();
    cells.iter().for_each(|cell| *counts.entry(without(cell)).or_default() += 1);
    cells.iter().map(|cell| counts[&without(cell)] == 1).collect()
}

/// The name of an arm: `control=torque,stiffness=100 %`.
pub fn arm_name(points: &[(String, String)], suite: &str) -> String {
    if points.is_empty() {
        return suite.to_owned();
    }
    points.iter().map(|(axis, point)| format!("{axis}={point}")).collect::<Vec<_>>().join(",")
}
