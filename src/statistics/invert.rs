//! P values from intervals: the level at which an interval first excludes a boundary.

use super::Interval;

/// Smallest level that is resolved.
const SMALLEST: f64 = 1e-9;

/// Two-sided p value for an estimate `value` against `boundary`, given its interval at each confidence;
/// `None` without an interval.
pub fn two_sided(value: f64, boundary: f64, interval: &dyn Fn(f64) -> Option<Interval>) -> Option<f64> {
    if value == boundary {
        return Some(1.0);
    }
    let holds = |level: f64| Some(interval(1.0 - level)?.contains(boundary));
    if !holds(SMALLEST)? {
        return Some(SMALLEST);
    }
    // The interval at this level contains the boundary, that at the next one does not.
    let (mut inside, mut outside) = (SMALLEST, 1.0);
    for _ in 0..60 {
        // Bisects geometrically, so that small levels are resolved, too.
        let middle = libm::sqrt(inside * outside);
        if holds(middle)? { inside = middle } else { outside = middle }
    }
    Some(outside.min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::proportion::{score_test, wilson};

    #[test]
    fn inverting_wilsons_interval_is_the_score_test() {
        let p = |boundary: f64| two_sided(0.6, boundary, &|confidence| Some(wilson(15, 25, confidence)));
        for boundary in [0.3, 0.5, 0.7, 0.9] {
            let (ours, exact) = (p(boundary).expect("a p"), score_test(15, 25, boundary).expect("a p"));
            assert!((ours - exact).abs() < 1e-6 * exact.max(1e-3), "{boundary}: {ours} is not {exact}");
        }
        assert_eq!(p(0.6), Some(1.0));
        assert_eq!(two_sided(0.6, 0.5, &|_| None), None);
    }
}
