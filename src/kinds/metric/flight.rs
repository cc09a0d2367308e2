//! The metric `flight`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "flight", since: Edition::ONE, doc: include_str!("flight.md"), params: &[], needs: &[] },
    label: "no foot on the ground",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.flight),
};
