//! The metric `cadence`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::outcome::Episode;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "cadence", since: Edition::ONE, doc: include_str!("cadence.md"), params: &[], needs: &[] },
    label: "touch-downs per second",
    unit: "/s",
    dimension: Dimension::RATE,
    digits: 2,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(cadence),
};

fn cadence(episode: &Episode) -> f64 {
    if episode.duration > 0.0 { f64::from(episode.steps[0] + episode.steps[1]) / episode.duration } else { 0.0 }
}
