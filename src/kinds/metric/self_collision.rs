//! The metric `self_collision`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "self_collision",
        since: Edition::ONE,
        doc: include_str!("self_collision.md"),
        params: &[],
        needs: &[],
    },
    label: "time with links inside each other",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::SomeEpisodes(|e| e.self_collision),
};
