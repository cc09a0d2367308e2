//! The metric `single_support`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "single_support",
        since: Edition::ONE,
        doc: include_str!("single_support.md"),
        params: &[],
        needs: &[],
    },
    label: "single support",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| e.single_support),
};
