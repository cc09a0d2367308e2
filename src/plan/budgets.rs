//! The samples that the trainings of a plan take: each ends after a whole update.

use std::collections::BTreeMap;

use super::graph::{Plan, Stage};
use super::stage::StageKind;
use crate::escape::terminal::one_line;
use crate::kinds::fine_tune;
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::in_whole_updates;
use crate::spec::Section;

/// The samples that a training takes.
pub fn samples(stage: &Stage) -> Option<u64> {
    let rollout = Section::new(&stage.fields).at(Ppo::rollout)?;
    Some(in_whole_updates(budget(stage)?, rollout as u64))
}

/// The samples that its spec gives a training.
fn budget(stage: &Stage) -> Option<u64> {
    let fields = Section::new(&stage.fields);
    match stage.kind {
        StageKind::Learner => fields.at(Ppo::samples).map(|samples| match fields.at(Ppo::stop_at) {
            Some(stop) => samples.min(stop),
            None => samples,
        }),
        StageKind::FineTune => fields.at(fine_tune::Ppo::samples),
        _ => None,
    }
}

/// A line for each budget that is not a whole number of updates: `learner: 3000000 samples take 3006464, 367 whole
/// updates of 8192`.
pub fn text(plan: &Plan) -> String {
    let mut found: BTreeMap<(StageKind, u64, u64), usize> = BTreeMap::new();
    for stage in plan.stages() {
        let fields = Section::new(&stage.fields);
        if let Some((samples, rollout)) = budget(stage).zip(fields.at(Ppo::rollout)) {
            *found.entry((stage.kind, samples, rollout as u64)).or_default() += 1;
        }
    }
    let several = found.len() > 1;
    let line = |((kind, samples, rollout), stages): ((StageKind, u64, u64), usize)| {
        let whole = in_whole_updates(samples, rollout);
        let of = if several { format!(" ({stages} of them)") } else { String::new() };
        let updates = whole / rollout.max(1);
        one_line(&format!(
            "{}{of}: {samples} samples take {whole}, {updates} whole updates of {rollout}",
            kind.name()
        ))
    };
    let odd = found
        .into_iter()
        .filter(|((_, samples, rollout), _)| in_whole_updates(*samples, *rollout) != *samples);
    let lines: String = odd.map(line).collect();
    if lines.is_empty() { lines } else { lines + "\n" }
}
