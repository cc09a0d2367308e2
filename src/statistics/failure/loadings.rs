//! The direction of failure: the first right-singular vector of the failed sets' deviations from the nominal
//! set.
//!
//! The deviations are *not* centred on the failed sets' mean. After centring, the vector would show where
//! failed sets vary, and they vary least along a parameter that fails on one side only; without centring it
//! shows where they lie.

use nalgebra::DMatrix;

use super::Sets;

/// A direction of failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Loadings {
    /// A unit vector with an entry for each parameter. Its sign is such that it points to the mean of the
    /// failed sets; if their mean is orthogonal to it, its largest entry is positive.
    pub direction: Vec<f64>,
    /// Share of the sum of squares along it.
    pub share: f64,
}

/// The direction of the failed sets, each weighted by its number of failures times its weight; `None` without
/// failures.
pub fn of(sets: &Sets, weights: &[f64]) -> Option<Loadings> {
    let count = sets.names.len();
    let mut squares = DMatrix::<f64>::zeros(count, count);
    let mut sum = vec![0.0; count];
    for ((row, failures), weight) in sets.rows.iter().zip(&sets.failures).zip(weights) {
        let weight = failures * weight;
        if weight == 0.0 {
            continue;
        }
        for (at, x) in row.iter().enumerate() {
            sum[at] += weight * x;
            row[..=at].iter().enumerate().for_each(|(other, y)| squares[(at, other)] += weight * x * y);
        }
    }
    squares.fill_upper_triangle_with_lower_triangle();
    let total = squares.trace();
    // Also if no parameter varies: an empty matrix has no eigenvectors.
    if total <= 0.0 {
        return None;
    }
    // The right-singular vectors of a matrix are the eigenvectors of its Gram matrix, and the squared
    // singular values are the eigenvalues.
    let eigen = squares.symmetric_eigen();
    let first = eigen.eigenvalues.imax();
    let mut direction: Vec<f64> = eigen.eigenvectors.column(first).iter().copied().collect();
    let along: f64 = direction.iter().zip(&sum).map(|(entry, sum)| entry * sum).sum();
    let largest = direction.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let towards = if along.abs() > 1e-9 * total { along } else { largest };
    if towards < 0.0 {
        direction.iter_mut().for_each(|entry| *entry = -*entry);
    }
    Some(Loadings { direction, share: eigen.eigenvalues[first] / total })
}

impl Loadings {
    /// Flips the sign if it points away from another direction: resamples may choose either sign.
    pub fn turn_like(&mut self, other: &Self) {
        let dot: f64 = self.direction.iter().zip(&other.direction).map(|(a, b)| a * b).sum();
        if dot < 0.0 {
            self.direction.iter_mut().for_each(|entry| *entry = -*entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(rows: &[[f64; 2]]) -> Sets {
        Sets {
            names: vec!["a".into(), "b".into()],
            rows: rows.iter().map(|row| row.to_vec()).collect(),
            failures: vec![1.0; rows.len()],
            trials: vec![1.0; rows.len()],
        }
    }

    #[test]
    fn failed_sets_on_a_line_give_that_line_towards_them() {
        let found = of(&sets(&[[-0.6, 0.8], [-0.3, 0.4]]), &[1.0, 1.0]).expect("failures");
        assert!(
            (found.direction[0] + 0.6).abs() < 1e-12 && (found.direction[1] - 0.8).abs() < 1e-12,
            "{found:?}"
        );
        assert!((found.share - 1.0).abs() < 1e-12);
    }

    #[test]
    fn failures_on_both_sides_have_a_direction_whose_largest_entry_is_positive() {
        let found =
            of(&sets(&[[-1.0, 0.0], [1.0, 0.0], [0.0, 0.1], [0.0, -0.1]]), &[1.0; 4]).expect("failures");
        assert!((found.direction[0] - 1.0).abs() < 1e-9, "{found:?}");
        // 2 of 2.02.
        assert!((found.share - 2.0 / 2.02).abs() < 1e-12);
    }

    #[test]
    fn a_set_that_did_not_fail_or_was_not_drawn_does_not_count() {
        let mut both = sets(&[[1.0, 0.0], [0.0, 1.0]]);
        assert!((of(&both, &[1.0, 0.0]).expect("one").direction[0] - 1.0).abs() < 1e-12);
        both.failures[0] = 0.0;
        assert!((of(&both, &[1.0, 1.0]).expect("one").direction[1] - 1.0).abs() < 1e-12);
        assert_eq!(of(&both, &[1.0, 0.0]), None);
    }
}
