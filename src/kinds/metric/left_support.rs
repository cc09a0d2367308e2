//! The metric `left_support`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "left_support",
        since: Edition::ONE,
        doc: include_str!("left_support.md"),
        params: &[],
        needs: &[],
    },
    label: "on the left foot alone",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.left_support),
};
