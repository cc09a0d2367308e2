//! The metric `steady_speed`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "steady_speed",
        since: Edition::ONE,
        doc: include_str!("steady_speed.md"),
        params: &[],
        needs: &[],
    },
    label: "speed in the second half",
    unit: "m/s",
    dimension: Dimension::VELOCITY,
    digits: 3,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.steady_speed),
};
