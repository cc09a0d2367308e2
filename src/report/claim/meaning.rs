//! Claims that are meaningless because robots fail their task: the speed, reward, force or torque of a robot
//! that falls says nothing about its training method. The same holds for episodes in which the simulation
//! diverged.

use super::Observed;
use crate::kinds::metric::MetricKind;
use crate::report::tasks;
use crate::spec::claim::{Case, Claim};

/// The names of the compared runs that fail their task, for a claim about such a metric.
pub fn failing(claim: &Claim, metric: &MetricKind, cases: &[Case], arms: &[Observed]) -> Vec<String> {
    if !metric.needs_task {
        return Vec::new();
    }
    let mut places: Vec<usize> = cases.iter().flat_map(|case| [Some(case.a), case.b]).flatten().collect();
    places.sort_unstable();
    places.dedup();
    let stages = || {
        let baseline = claim.baseline.iter().map(|baseline| baseline.stage.as_str());
        baseline.chain([claim.metric.stage.as_str()])
    };
    let runs = places
        .into_iter()
        .flat_map(|place| arms[place].runs.iter().map(move |(seed, run)| (place, *seed, *run)));
    let fails = |run: &crate::report::model::Arm| {
        stages().any(|stage| tasks::does(run, stage) == Some(false) || tasks::explodes(run, stage))
    };
    let failing = runs.filter(|(_, _, run)| fails(run));
    failing
        .map(|(place, seed, _)| format!("{},seed={seed}", super::sample::name(arms[place].points)))
        .collect()
}
