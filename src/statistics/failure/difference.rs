//! Standardised mean differences (Cohen's d): the distance between the means of a parameter over failed and
//! other sets.

use super::Sets;

/// Failed minus survived, in units of the root of the mean of both variances, for each parameter. `None` if a
/// side has fewer than two trials or no spread.
pub fn of(sets: &Sets, weights: &[f64]) -> Option<Vec<f64>> {
    (0..sets.names.len()).map(|at| one(sets, weights, at)).collect()
}

fn one(sets: &Sets, weights: &[f64], at: usize) -> Option<f64> {
    let failed = || sets.failures.iter().zip(weights).map(|(failures, weight)| failures * weight);
    let survived = || {
        let counts = sets.failures.iter().zip(&sets.trials).zip(weights);
        counts.map(|((failures, trials), weight)| (trials - failures) * weight)
    };
    let values = || sets.rows.iter().map(|row| row[at]);
    let (first, second) = (moments(values(), failed())?, moments(values(), survived())?);
    let spread = libm::sqrt(0.5 * (first[1] + second[1]));
    (spread > 0.0).then(|| (first[0] - second[0]) / spread)
}

/// Weighted mean and variance (divisor n - 1).
fn moments(
    values: impl Iterator<Item = f64> + Clone,
    counts: impl Iterator<Item = f64> + Clone,
) -> Option<[f64; 2]> {
    let n: f64 = counts.clone().sum();
    if n < 2.0 {
        return None;
    }
    let mean = values.clone().zip(counts.clone()).map(|(value, count)| count * value).sum::<f64>() / n;
    let squares: f64 = values.zip(counts).map(|(value, count)| count * (value - mean) * (value - mean)).sum();
    Some([mean, squares / (n - 1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_is_that_computed_by_hand() {
        let sets = Sets {
            names: vec!["a".into()],
            rows: [[0.0], [2.0], [3.0], [5.0]].map(|row| row.to_vec()).into(),
            failures: vec![0.0, 0.0, 1.0, 1.0],
            trials: vec![1.0; 4],
        };
        // Means 4 and 1, both variances 2.
        let found = of(&sets, &[1.0; 4]).expect("two and two");
        assert!((found[0] - 3.0 / 2.0_f64.sqrt()).abs() < 1e-12, "{found:?}");
        assert_eq!(of(&sets, &[1.0, 1.0, 1.0, 0.0]), None);
    }
}
