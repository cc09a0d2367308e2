//! The metric `failure_loading`.

use super::{Better, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "failure_loading",
        since: Edition::ONE,
        doc: include_str!("failure_loading.md"),
        params: &[],
        needs: &[],
    },
    label: "loading of a parameter in the direction of failure",
    unit: "",
    dimension: Dimension::NONE,
    digits: 2,
    tasks: &[],
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: false,
    source: Source::Failures(|failures| failures.loading()),
};

#[cfg(test)]
mod tests {
    use super::super::Failures;

    #[test]
    fn an_entry_counts_by_its_size() {
        let direction = [("action_delay".to_owned(), -0.8), ("leg_length".to_owned(), 0.6)];
        let of = |parameter| (Failures { direction: &direction, parameter }).loading();
        assert_eq!(["action_delay", "leg_length", "link_mass"].map(of), [Some(0.8), Some(0.6), None]);
    }
}
