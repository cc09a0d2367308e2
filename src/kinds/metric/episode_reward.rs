//! The metric `episode_reward`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "episode_reward",
        since: Edition::ONE,
        doc: include_str!("episode_reward.md"),
        params: &[],
        needs: &[],
    },
    label: "reward of an episode",
    unit: "",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::PerStep,
    needs_task: true,
    tabled: false,
    source: Source::Episodes(|e| e.duration * e.reward_per_second.values().sum::<f64>()),
};
