//! W0508 in reports: trainings that never updated the actor, so that the policy is the one they began with.

use super::model::Arm;
use crate::kinds::learn::Ppo;
use crate::kinds::pretrain::Pretraining;
use crate::plan::Training;

/// Whether a training has run and never updated the actor: all its updates were the critic's warm-up, or it
/// stopped before the first. A spec with `learn.samples = 0` trains nothing, which is its intention.
pub fn is_untrained(arm: &Arm) -> bool {
    let section = arm.section();
    if section.at(Ppo::samples).is_none_or(|samples| samples == 0) {
        return false;
    }
    match (arm.updates.last(), section.at(Ppo::warm_up)) {
        (Some(last), Some(warm_up)) => last.update < warm_up,
        (Some(_), None) => false,
        (None, _) => arm.stage(Training::First.stage()).is_some(),
    }
}

/// What the policy of an untrained arm is.
pub fn network(arm: &Arm) -> &'static str {
    if arm.kind::<Pretraining>().is_empty() { "an untrained network" } else { "the pre-trained network" }
}

/// Why a training never updated the actor.
pub fn cause(arm: &Arm) -> &'static str {
    if arm.updates.is_empty() {
        "the training stopped before its first update"
    } else {
        "all updates were the critic's warm-up"
    }
}
