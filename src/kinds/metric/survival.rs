//! The metric `survival`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind { name: "survival", since: Edition::ONE, doc: include_str!("survival.md"), params: &[], needs: &[] },
    label: "survival",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Success,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: true,
    source: Source::Episodes(|e| f64::from(u8::from(e.survived))),
};
