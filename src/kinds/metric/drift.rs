//! The metric `drift`.

use super::{Better, MetricKind, STAYING, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "drift", since: Edition::ONE, doc: include_str!("drift.md"), params: &[], needs: &[] },
    label: "largest distance of the base from its start",
    unit: "m",
    dimension: Dimension::LENGTH,
    digits: 3,
    tasks: STAYING,
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::SomeEpisodes(|e| e.drift),
};
