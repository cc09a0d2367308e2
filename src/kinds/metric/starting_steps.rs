//! The metric `starting_steps`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "starting_steps",
        since: Edition::ONE,
        doc: include_str!("starting_steps.md"),
        params: &[],
        needs: &[],
    },
    label: "steps until every step has a flight phase",
    unit: "",
    dimension: Dimension::NONE,
    digits: 1,
    tasks: &["run"],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| f64::from(e.starting_steps)),
};
