//! The metric `speed`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "speed", since: Edition::ONE, doc: include_str!("speed.md"), params: &[], needs: &[] },
    label: "mean forward speed",
    unit: "m/s",
    dimension: Dimension::VELOCITY,
    digits: 3,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.speed),
};
