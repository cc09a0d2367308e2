//! The metric `samples_to_threshold`.

use super::{Better, Curve, MetricKind, Scale, Source, Sums};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: MetricKind = MetricKind {
    kind: Kind {
        name: "samples_to_threshold",
        since: Edition::ONE,
        doc: include_str!("samples_to_threshold.md"),
        params: &[],
        needs: &[],
    },
    label: "samples until the return reaches the threshold",
    unit: "",
    dimension: Dimension::NONE,
    digits: 0,
    tasks: &[],
    better: Better::Lower,
    scale: Scale::Censored,
    sums: Sums::PerStep,
    needs_task: false,
    tabled: false,
    source: Source::Learning(value),
};

/// Updates that are averaged, so that one lucky update does not count.
const WINDOW: usize = 5;

fn value(curve: &Curve) -> Option<f64> {
    let threshold = curve.threshold?;
    curve.points.first()?;
    let reached = curve.points.windows(WINDOW.min(curve.points.len())).find(|window| {
        let sum: f64 = window.iter().map(|(_, episodes)| episodes).sum();
        sum / window.len() as f64 >= threshold
    });
    Some(reached.and_then(|window| window.last()).map_or(f64::INFINITY, |(samples, _)| *samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_lucky_update_does_not_count_and_never_is_infinite() {
        let mut points: Vec<(f64, f64)> = (1..=20).map(|update| (f64::from(100 * update), 0.0)).collect();
        points[3].1 = 8.0;
        let reached = |points: &[(f64, f64)]| value(&Curve { points, threshold: Some(2.0), control_step: None });
        assert_eq!(reached(&points), Some(f64::INFINITY));
        points[10..].iter_mut().for_each(|point| point.1 = 2.0);
        assert_eq!(reached(&points), Some(1500.0));
        assert_eq!(value(&Curve { points: &points, threshold: None, control_step: None }), None);
    }
}
