//! Metrics of learning curves.

use super::Curve;

/// The mean return over the samples, by the trapezoidal rule.
pub(super) fn area_under_curve(curve: &Curve) -> Option<f64> {
    let (first, last) = (curve.points.first()?, curve.points.last()?);
    if last.0 <= first.0 {
        return Some(first.1);
    }
    let area: f64 =
        curve.points.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum();
    Some(area / (last.0 - first.0))
}

/// The mean return of the last tenth of the updates.
pub(super) fn final_return(curve: &Curve) -> Option<f64> {
    let points = curve.points;
    let first = points.len() - points.len().div_ceil(10);
    let last = &points[first..];
    (!last.is_empty()).then(|| last.iter().map(|(_, episodes)| episodes).sum::<f64>() / last.len() as f64)
}

/// The mean return times the control step in s, which compares control rates.
pub(super) fn final_return_time(curve: &Curve) -> Option<f64> {
    Some(final_return(curve)? * curve.control_step?)
}

/// Number of updates in the moving average, so that a single lucky update does not count.
const WINDOW: usize = 5;

/// The samples after which the return reaches the threshold; infinite if it never does.
pub(super) fn samples_to_threshold(curve: &Curve) -> Option<f64> {
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
    fn a_curve_is_averaged_over_its_samples() {
        // Trapezoids: (0 + 4) / 2 * 10 + 4 * 30 = 140 over 40 samples.
        let points = [(10.0, 0.0), (20.0, 4.0), (50.0, 4.0)];
        assert_eq!(
            area_under_curve(&Curve { points: &points, threshold: None, control_step: None }),
            Some(3.5)
        );
        assert_eq!(
            area_under_curve(&Curve { points: &points[..1], threshold: None, control_step: None }),
            Some(0.0)
        );
        assert_eq!(area_under_curve(&Curve { points: &[], threshold: None, control_step: None }), None);
    }

    #[test]
    fn the_last_tenth_counts() {
        let points: Vec<(f64, f64)> = (1..=20).map(|update| (f64::from(update), f64::from(update))).collect();
        assert_eq!(final_return(&Curve { points: &points, threshold: None, control_step: None }), Some(19.5));
        assert_eq!(
            final_return(&Curve { points: &points[..3], threshold: None, control_step: None }),
            Some(3.0)
        );
        assert_eq!(final_return(&Curve { points: &[], threshold: None, control_step: None }), None);
    }

    #[test]
    fn a_return_counts_by_the_time_of_its_steps() {
        let curve = Curve { points: &[(1.0, 2000.0)], control_step: Some(0.008), threshold: None };
        assert_eq!(final_return_time(&curve), Some(16.0));
        assert_eq!(final_return_time(&Curve { control_step: None, ..curve }), None);
        assert_eq!(final_return_time(&Curve { points: &[], ..curve }), None);
    }

    #[test]
    fn one_lucky_update_does_not_count_and_never_is_infinite() {
        let mut points: Vec<(f64, f64)> = (1..=20).map(|update| (f64::from(100 * update), 0.0)).collect();
        points[3].1 = 8.0;
        let reached = |points: &[(f64, f64)]| {
            samples_to_threshold(&Curve { points, threshold: Some(2.0), control_step: None })
        };
        assert_eq!(reached(&points), Some(f64::INFINITY));
        points[10..].iter_mut().for_each(|point| point.1 = 2.0);
        assert_eq!(reached(&points), Some(1500.0));
        assert_eq!(
            samples_to_threshold(&Curve { points: &points, threshold: None, control_step: None }),
            None
        );
    }
}
