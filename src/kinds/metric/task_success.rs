//! The metric `task_success`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "task_success",
        since: Edition::ONE,
        doc: include_str!("task_success.md"),
        params: &[],
        needs: &[],
    },
    label: "task success",
    unit: "%",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Success,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: false,
    source: Source::Task,
};
