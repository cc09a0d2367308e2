//! The metric `surviving_reward_deviation`.

use super::surviving_reward::{self, rewards};
use super::{Better, MetricKind, Scale, Source, Sums};
use crate::outcome::Episode;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "surviving_reward_deviation",
        since: Edition::ONE,
        doc: include_str!("surviving_reward_deviation.md"),
        params: &[],
        needs: &[],
    },
    label: "deviation of the reward of episodes that survive",
    unit: "",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::PerStep,
    needs_task: true,
    tabled: false,
    source: Source::Whole(value),
};

fn value(episodes: &[Episode]) -> Option<f64> {
    let (mean, rewards) = (surviving_reward::value(episodes)?, rewards(episodes));
    let squares: f64 = rewards.iter().map(|reward| (reward - mean) * (reward - mean)).sum();
    (rewards.len() > 1).then(|| libm::sqrt(squares / (rewards.len() - 1) as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_is_that_of_the_survivors() {
        let episode = |survived, reward| Episode {
            survived,
            duration: 1.0,
            reward_per_second: [("a".to_owned(), reward)].into(),
            ..Episode::default()
        };
        let episodes = [episode(true, 1.0), episode(false, 9.0), episode(true, 3.0)];
        assert_eq!(value(&episodes), Some(core::f64::consts::SQRT_2));
        assert_eq!(value(&episodes[..2]), None);
    }
}
