//! The metric `left_steps`.

use super::{Better, MOVING, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "left_steps", since: Edition::ONE, doc: include_str!("left_steps.md"), params: &[], needs: &[] },
    label: "steps of the left foot",
    unit: "",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: MOVING,
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| f64::from(e.steps[0])),
};
