//! The metric `flight_per_step`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "flight_per_step",
        since: Edition::ONE,
        doc: include_str!("flight_per_step.md"),
        params: &[],
        needs: &[],
    },
    label: "steps with a flight phase",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &["run"],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.flight_per_step),
};
