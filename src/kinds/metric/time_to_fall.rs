//! The metric `time_to_fall`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "time_to_fall",
        since: Edition::ONE,
        doc: include_str!("time_to_fall.md"),
        params: &[],
        needs: &[],
    },
    label: "time until the fall or the limit",
    unit: "s",
    dimension: Dimension::TIME,
    digits: 2,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.duration),
};
