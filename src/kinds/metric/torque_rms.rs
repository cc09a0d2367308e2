//! The metric `torque_rms`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "torque_rms", since: Edition::ONE, doc: include_str!("torque_rms.md"), params: &[], needs: &[] },
    label: "torque rms",
    unit: "N m",
    dimension: Dimension::TORQUE,
    digits: 1,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: true,
    tabled: true,
    source: Source::Episodes(|e| e.torque_rms),
};
