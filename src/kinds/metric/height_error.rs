//! The metric `height_error`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "height_error",
        since: Edition::ONE,
        doc: include_str!("height_error.md"),
        params: &[],
        needs: &[],
    },
    label: "largest base-height distance from the reference",
    unit: "m",
    dimension: Dimension::LENGTH,
    digits: 3,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.tracking_error[1]),
};
