//! The metric `failure_dominance`.

use super::{Better, Failures, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "failure_dominance",
        since: Edition::ONE,
        doc: include_str!("failure_dominance.md"),
        params: &[],
        needs: &[],
    },
    label: "lead of a parameter in the direction of failure",
    unit: "",
    dimension: Dimension::NONE,
    digits: 2,
    tasks: &[],
    better: Better::Neither,
    scale: Scale::Real,
    sums: Sums::Nothing,
    needs_task: false,
    tabled: false,
    source: Source::Failures(value),
};

fn value(failures: &Failures) -> Option<f64> {
    Some(failures.loading()? - failures.largest_other()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_parameter_leads_and_the_others_lag() {
        let direction = [("action_delay".to_owned(), 0.8), ("leg_length".to_owned(), -0.6)];
        let of = |parameter| value(&Failures { direction: &direction, parameter }).expect("a lead");
        assert!((of("action_delay") - 0.2).abs() < 1e-12 && (of("leg_length") + 0.2).abs() < 1e-12);
        assert_eq!(value(&Failures { direction: &direction, parameter: "link_mass" }), None);
    }
}
