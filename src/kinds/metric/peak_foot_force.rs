//! The metric `peak_foot_force`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "peak_foot_force",
        since: Edition::ONE,
        doc: include_str!("peak_foot_force.md"),
        params: &[],
        needs: &[],
    },
    label: "peak vertical foot force",
    unit: "N",
    dimension: Dimension::FORCE,
    digits: 0,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.peak_foot_force),
};
