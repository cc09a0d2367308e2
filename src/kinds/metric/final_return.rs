//! The metric `final_return`.

use super::{Better, Curve, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "final_return",
        since: Edition::ONE,
        doc: include_str!("final_return.md"),
        params: &[],
        needs: &[],
    },
    label: "return at the end of learning",
    unit: "",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Higher,
    scale: Scale::Real,
    sums: Sums::PerStep,
    needs_task: false,
    tabled: false,
    source: Source::Learning(value),
};

pub(super) fn value(curve: &Curve) -> Option<f64> {
    let points = curve.points;
    let first = points.len() - points.len().div_ceil(10);
    let last = &points[first..];
    (!last.is_empty()).then(|| last.iter().map(|(_, episodes)| episodes).sum::<f64>() / last.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_tenth_counts() {
        let points: Vec<(f64, f64)> = (1..=20).map(|update| (f64::from(update), f64::from(update))).collect();
        assert_eq!(value(&Curve { points: &points, threshold: None, control_step: None }), Some(19.5));
        assert_eq!(value(&Curve { points: &points[..3], threshold: None, control_step: None }), Some(3.0));
        assert_eq!(value(&Curve { points: &[], threshold: None, control_step: None }), None);
    }
}
