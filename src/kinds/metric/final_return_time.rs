//! The metric `final_return_time`.

use super::{Better, Curve, MetricKind, Scale, Source, Sums, final_return};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "final_return_time",
        since: Edition::ONE,
        doc: include_str!("final_return_time.md"),
        params: &[],
        needs: &[],
    },
    label: "return times control step at the end of learning",
    unit: "s",
    dimension: Dimension::TIME,
    digits: 1,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::PerTime,
    needs_task: false,
    tabled: false,
    source: Source::Learning(value),
};

fn value(curve: &Curve) -> Option<f64> {
    Some(final_return::value(curve)? * curve.control_step?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_return_counts_by_the_time_of_its_steps() {
        let curve = Curve { points: &[(1.0, 2000.0)], control_step: Some(0.008), threshold: None };
        assert_eq!(value(&curve), Some(16.0));
        assert_eq!(value(&Curve { control_step: None, ..curve }), None);
        assert_eq!(value(&Curve { points: &[], ..curve }), None);
    }
}
