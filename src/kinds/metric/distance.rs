//! The metric `distance`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "distance", since: Edition::ONE, doc: include_str!("distance.md"), params: &[], needs: &[] },
    label: "distance",
    unit: "m",
    dimension: Dimension::LENGTH,
    digits: 2,
    tasks: MOVING,
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.distance),
};
