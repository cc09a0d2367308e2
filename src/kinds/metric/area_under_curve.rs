//! The metric `area_under_curve`.

use super::{Better, Curve, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "area_under_curve",
        since: Edition::ONE,
        doc: include_str!("area_under_curve.md"),
        params: &[],
        needs: &[],
    },
    label: "mean return over the learning",
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

fn value(curve: &Curve) -> Option<f64> {
    let (first, last) = (curve.points.first()?, curve.points.last()?);
    if last.0 <= first.0 {
        return Some(first.1);
    }
    let area: f64 = curve.points.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum();
    Some(area / (last.0 - first.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_averaged_over_its_samples() {
        // Trapezoids: (0 + 4) / 2 * 10 + 4 * 30 = 140 over 40 samples.
        let points = [(10.0, 0.0), (20.0, 4.0), (50.0, 4.0)];
        assert_eq!(value(&Curve { points: &points, threshold: None, control_step: None }), Some(3.5));
        assert_eq!(value(&Curve { points: &points[..1], threshold: None, control_step: None }), Some(0.0));
        assert_eq!(value(&Curve { points: &[], threshold: None, control_step: None }), None);
    }
}
