//! The metric `steady_flight_per_step`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "steady_flight_per_step",
        since: Edition::ONE,
        doc: include_str!("steady_flight_per_step.md"),
        params: &[],
        needs: &[],
    },
    label: "steps with a flight phase, second half",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &["run"],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.steady_flight_per_step),
};
