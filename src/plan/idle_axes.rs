//! Axes of a sweep that change no stage: all their points are the same experiment.

use std::collections::BTreeMap;

use super::graph::{ArmRecord, Plan};
use super::stage::StageKind;

/// Of groups of axes that vary together, given by name, those along which no arm's stages differ. An axis along
/// which no two arms lie is not counted. Reports are left out: each is of the whole suite.
pub fn idle_axes(plan: &Plan, groups: &[Vec<String>]) -> Vec<usize> {
    let idle = |group: &&Vec<String>| {
        let mut rows: BTreeMap<Vec<(&str, &str)>, Vec<&ArmRecord>> = BTreeMap::new();
        for arm in &plan.arms {
            let Some(run) = &arm.run else { continue };
            let others = run.points.iter().filter(|(axis, _)| !group.contains(axis));
            let others = others.map(|(axis, point)| (axis.as_str(), point.as_str())).collect();
            rows.entry(others).or_default().push(arm);
        }
        rows.retain(|_, arms| arms.len() > 1);
        let stages = |arm: &ArmRecord| -> BTreeMap<String, String> {
            let own = arm.stages.iter();
            let own =
                own.filter(|(_, key)| plan.stage(key).is_some_and(|stage| stage.kind != StageKind::Report));
            own.map(|(name, key)| (name.clone(), key.as_str().to_owned())).collect()
        };
        let alike = |arms: &Vec<&ArmRecord>| {
            let first = stages(arms[0]);
            arms[1..].iter().all(|arm| stages(arm) == first)
        };
        !rows.is_empty() && rows.values().all(alike)
    };
    groups.iter().enumerate().filter(|(_, group)| idle(group)).map(|(index, _)| index).collect()
}
