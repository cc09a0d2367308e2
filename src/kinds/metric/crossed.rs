//! The metric `crossed`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Signal};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "crossed",
        since: Edition::ONE,
        doc: include_str!("crossed.md"),
        params: &[],
        needs: &[Signal::Obstacle],
    },
    label: "crossed the obstacle",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Success,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::SomeEpisodes(|e| e.crossed.map(|crossed| f64::from(u8::from(crossed)))),
};
