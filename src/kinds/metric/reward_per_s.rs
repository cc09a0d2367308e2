//! The metric `reward_per_s`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "reward_per_s",
        since: Edition::ONE,
        doc: include_str!("reward_per_s.md"),
        params: &[],
        needs: &[],
    },
    label: "reward per second",
    unit: "/s",
    dimension: Dimension::RATE,
    digits: 1,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::PerStep,
    needs_task: true,
    tabled: false,
    source: Source::Episodes(|e| e.reward_per_second.values().sum()),
};
