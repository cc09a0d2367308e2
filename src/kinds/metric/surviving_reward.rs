//! The metric `surviving_reward`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::outcome::Episode;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "surviving_reward",
        since: Edition::ONE,
        doc: include_str!("surviving_reward.md"),
        params: &[],
        needs: &[],
    },
    label: "reward of an episode that survives",
    unit: "",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::PerStep,
    needs_task: true,
    tabled: false,
    source: Source::Whole(value),
};

/// Their mean; `None` when none survives.
pub(super) fn value(episodes: &[Episode]) -> Option<f64> {
    let rewards = rewards(episodes);
    (!rewards.is_empty()).then(|| rewards.iter().sum::<f64>() / rewards.len() as f64)
}

/// The rewards of the episodes that survive.
pub(super) fn rewards(episodes: &[Episode]) -> Vec<f64> {
    let alive = episodes.iter().filter(|episode| episode.survived);
    alive.map(|episode| episode.duration * episode.reward_per_second.values().sum::<f64>()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_episodes_that_survive_count() {
        let episode = |survived, reward| Episode {
            survived,
            duration: 2.0,
            reward_per_second: [("a".to_owned(), reward)].into(),
            ..Episode::default()
        };
        let episodes = [episode(true, 1.0), episode(false, 9.0), episode(true, 2.0)];
        assert_eq!((value(&episodes), value(&episodes[1..2])), (Some(3.0), None));
    }
}
