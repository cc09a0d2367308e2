//! Rank statistics of two samples: the probability of improvement, and the exact Mann-Whitney test with the
//! Hodges-Lehmann shift. Infinite values rank above all others.

use super::Interval;
use super::summary::median;

/// Share of all pairs in which the first value exceeds the second, ties counting one half; `None` if a sample
/// is empty.
pub fn improvement(first: &[f64], second: &[f64]) -> Option<f64> {
    let pairs = (first.len() * second.len()) as f64;
    (pairs > 0.0).then(|| wins(first, second) / pairs)
}

/// The statistic U of the first sample: number of pairs that it wins, ties counting one half.
fn wins(first: &[f64], second: &[f64]) -> f64 {
    let score = |x: &f64, y: &f64| match x.total_cmp(y) {
        std::cmp::Ordering::Greater => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Less => 0.0,
    };
    first.iter().map(|x| second.iter().map(|y| score(x, y)).sum::<f64>()).sum()
}

/// The probability of each value of U for samples of n and m values from the same continuous distribution
/// (Mann and Whitney 1947).
pub fn distribution(n: usize, m: usize) -> Vec<f64> {
    // The Gaussian binomial coefficient: multiply by 1 - q^(m+i), divide by 1 - q^i.
    let mut counts = vec![0.0; n * m + 1];
    counts[0] = 1.0;
    for i in 1..=n {
        for at in (m + i..counts.len()).rev() {
            counts[at] -= counts[at - m - i];
        }
        for at in i..counts.len() {
            counts[at] += counts[at - i];
        }
    }
    let total: f64 = counts.iter().sum();
    counts.iter().map(|count| count / total).collect()
}

/// Two-sided p value for both samples having the same distribution; `None` if one is empty. Conservative with
/// ties.
pub fn mann_whitney(first: &[f64], second: &[f64]) -> Option<f64> {
    let (n, m) = (first.len(), second.len());
    if n == 0 || m == 0 {
        return None;
    }
    let u = wins(first, second);
    let larger = u.max((n * m) as f64 - u);
    let tail: f64 = distribution(n, m)[larger as usize..].iter().sum();
    Some((2.0 * tail).min(1.0))
}

/// The Hodges-Lehmann shift of the first sample over the second: the median of all pairwise differences;
/// `None` if a sample is empty.
pub fn shift(first: &[f64], second: &[f64]) -> Option<f64> {
    median(&differences(first, second))
}

/// The exact interval of the shift: the differences that the two-sided test does not reject. `None` if the
/// samples are too small for this confidence.
pub fn shift_interval(first: &[f64], second: &[f64], confidence: f64) -> Option<Interval> {
    let tail = 0.5 - 0.5 * confidence;
    let mut sum = 0.0;
    let below = distribution(first.len(), second.len()).into_iter().take_while(|chance| {
        sum += chance;
        sum <= tail + 1e-12
    });
    let cut = below.count();
    let differences = differences(first, second);
    (cut > 0).then(|| Interval { low: differences[cut - 1], high: differences[differences.len() - cut] })
}

/// All differences between a value of the first and one of the second, sorted. Two infinite values have the
/// difference zero.
fn differences(first: &[f64], second: &[f64]) -> Vec<f64> {
    let difference = |x: f64, y: f64| if x == y { 0.0 } else { x - y };
    let mut all: Vec<f64> =
        first.iter().flat_map(|x| second.iter().map(move |y| difference(*x, *y))).collect();
    all.sort_by(f64::total_cmp);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_of_u_is_that_of_all_orders() {
        // Of the 6 orders of two and two: U = 0, 1, 2, 2, 3, 4.
        let expected = [1.0, 1.0, 2.0, 1.0, 1.0].map(|count| count / 6.0);
        assert!(distribution(2, 2).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
        let wide = distribution(30, 25);
        assert!((wide.iter().sum::<f64>() - 1.0).abs() < 1e-12 && (wide[100] - wide[650]).abs() < 1e-12);
    }

    #[test]
    fn ties_count_half_and_never_comes_last() {
        assert_eq!(improvement(&[1.0, 2.0], &[1.0, 0.0]), Some(0.875));
        assert_eq!(improvement(&[f64::INFINITY, 3.0], &[4.0, f64::INFINITY]), Some(0.375));
        assert_eq!(shift(&[f64::INFINITY; 3], &[f64::INFINITY; 3]), Some(0.0));
        assert_eq!(improvement(&[], &[1.0]), None);
    }

    #[test]
    fn three_and_three_runs_have_no_exact_interval_of_95_percent() {
        assert_eq!(shift_interval(&[4.0, 5.0, 6.0], &[1.0, 2.0, 3.0], 0.95), None);
        let interval =
            shift_interval(&[4.0, 5.0, 6.0, 7.0], &[0.0, 1.0, 2.0, 3.0], 0.95).expect("four and four");
        assert_eq!(interval, Interval { low: 1.0, high: 7.0 });
    }
}
