//! The metric `speed_error`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "speed_error",
        since: Edition::ONE,
        doc: include_str!("speed_error.md"),
        params: &[],
        needs: &[],
    },
    label: "speed error",
    unit: "m/s",
    dimension: Dimension::VELOCITY,
    digits: 3,
    tasks: MOVING,
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.speed_error),
};
