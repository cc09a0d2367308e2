//! The runs of a suite, grouped by arm.

use super::model::{Arm, ReportInput};
use super::source::Source;

/// An arm of a suite with its runs, in seed order.
#[derive(Clone, Debug)]
pub struct Group<'a> {
    /// The arm: `control=torque,stiffness=100 %`.
    pub name: &'a str,
    /// Its points by axis.
    pub points: &'a [(String, String)],
    /// Its runs.
    pub runs: Vec<&'a Arm>,
}

impl Group<'_> {
    /// A value for every run that has it.
    pub fn values(&self, of: impl Fn(&Arm) -> Option<f64>) -> Vec<f64> {
        self.runs.iter().filter_map(|run| of(run)).collect()
    }

    /// Its point on an axis.
    pub fn point(&self, axis: &str) -> Option<&str> {
        self.points.iter().find(|(name, _)| name == axis).map(|(_, point)| point.as_str())
    }

    /// Its name without the points on these axes, unless that leaves nothing.
    pub fn name_without(&self, axes: &[&str]) -> String {
        let rest = self.points.iter().filter(|(axis, _)| !axes.contains(&axis.as_str()));
        let rest: Vec<String> = rest.map(|(axis, point)| format!("{axis}={point}")).collect();
        if rest.is_empty() { self.name.to_owned() } else { rest.join(",") }
    }
}

/// The arms of a suite in sweep order; empty for other reports.
pub fn groups(input: &ReportInput) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for arm in &input.arms {
        let Some(run) = &arm.run else { continue };
        // The runs of an arm are consecutive.
        match groups.last_mut().filter(|group| group.name == run.arm) {
            Some(group) => group.runs.push(arm),
            None => groups.push(Group { name: &run.arm, points: &run.points, runs: vec![arm] }),
        }
    }
    groups
}

/// The axes on which the arms differ, with the points that occur, both in sweep order.
pub fn varying<'a>(input: &'a ReportInput, groups: &[Group<'_>]) -> Vec<(&'a str, Vec<&'a str>)> {
    let axes = input.suite.iter().flat_map(|suite| &suite.axes);
    let used = axes.map(|axis| {
        let has =
            |point: &&String| groups.iter().any(|group| group.point(&axis.name) == Some(point.as_str()));
        (axis.name.as_str(), axis.points.iter().filter(has).map(String::as_str).collect::<Vec<_>>())
    });
    used.filter(|(_, points)| points.len() > 1).collect()
}

/// A stage of every run that has it.
pub fn sources(groups: &[Group<'_>], stage: &str) -> Vec<Source> {
    let runs = groups.iter().flat_map(|group| &group.runs).filter(|run| run.stage(stage).is_some());
    runs.map(|run| Source { arm: run.name.clone(), stage: stage.to_owned() }).collect()
}
