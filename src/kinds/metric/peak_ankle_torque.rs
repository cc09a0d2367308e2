//! The metric `peak_ankle_torque`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "peak_ankle_torque",
        since: Edition::ONE,
        doc: include_str!("peak_ankle_torque.md"),
        params: &[],
        needs: &[],
    },
    label: "peak ankle pitch torque",
    unit: "N m",
    dimension: Dimension::TORQUE,
    digits: 0,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::SomeEpisodes(|e| e.peak_ankle_torque),
};
