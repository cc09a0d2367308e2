//! Summaries of a sample: mean, deviation, quantiles, trimmed mean.

/// The arithmetic mean; `None` for an empty sample.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The standard deviation (divisor n - 1); `None` with fewer than two values.
pub fn deviation(values: &[f64]) -> Option<f64> {
    let centre = mean(values)?;
    let squares: f64 = values.iter().map(|value| (value - centre) * (value - centre)).sum();
    (values.len() > 1).then(|| libm::sqrt(squares / (values.len() - 1) as f64))
}

/// The quantile at `share` in [0, 1], interpolated between order statistics (Hyndman and Fan's type 7);
/// `None` for an empty sample.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

/// [`quantile`] of a sorted sample.
pub fn quantile_of_sorted(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let index = place as usize;
    let (this, next) = (sorted[index], sorted[(index + 1).min(last)]);
    let share = place - index as f64;
    // Infinite values cannot be interpolated.
    Some(if share == 0.0 || this == next { this } else { this + share * (next - this) })
}

/// The median; `None` for an empty sample.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The interquartile mean: a quarter trimmed from each end (Agarwal et al. 2021); `None` for an empty
/// sample.
pub fn interquartile_mean(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_sample_has_the_summaries_computed_by_hand() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(mean(&values), Some(2.5));
        assert_eq!(median(&values), Some(2.5));
        assert_eq!(quantile(&values, 0.25), Some(1.75));
        assert_eq!(quantile(&values, 1.0), Some(4.0));
        assert_eq!(median(&[1.0, f64::INFINITY, f64::INFINITY, f64::INFINITY]), Some(f64::INFINITY));
        let deviation = deviation(&values).expect("four values");
        assert!((deviation - libm::sqrt(5.0 / 3.0)).abs() < 1e-15);
    }

    #[test]
    fn the_interquartile_mean_ignores_an_outlier() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1000.0];
        assert_eq!(interquartile_mean(&values), Some(4.5));
    }

    #[test]
    fn an_empty_sample_has_no_summary() {
        assert_eq!(
            (mean(&[]), median(&[]), deviation(&[1.0]), interquartile_mean(&[])),
            (None, None, None, None)
        );
    }
}
