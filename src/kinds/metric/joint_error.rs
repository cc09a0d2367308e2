//! The metric `joint_error`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "joint_error",
        since: Edition::ONE,
        doc: include_str!("joint_error.md"),
        params: &[],
        needs: &[],
    },
    label: "largest joint distance from the reference",
    unit: "rad",
    dimension: Dimension::ANGLE,
    digits: 3,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.tracking_error[0]),
};
