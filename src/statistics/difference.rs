//! Differences of two proportions, independent or paired, with Newcombe's intervals.

use super::Interval;
use super::proportion::wilson;

/// Difference of two independent proportions `[successes, trials]` and Newcombe's hybrid score interval
/// (Newcombe 1998, Statistics in Medicine 17:873, method 10).
pub fn independent(first: [u64; 2], second: [u64; 2], confidence: f64) -> (f64, Interval) {
    hybrid(first, second, 0.0, confidence)
}

/// Outcomes of paired trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Both succeeded.
    pub both: u64,
    /// Only the first succeeded.
    pub only_first: u64,
    /// Only the second succeeded.
    pub only_second: u64,
    /// Neither succeeded.
    pub neither: u64,
}

impl Pairs {
    /// Counts the pairs of two equally long lists.
    pub fn count(first: &[bool], second: &[bool]) -> Self {
        let mut pairs = Self::default();
        for outcome in first.iter().zip(second) {
            match outcome {
                (true, true) => pairs.both += 1,
                (true, false) => pairs.only_first += 1,
                (false, true) => pairs.only_second += 1,
                (false, false) => pairs.neither += 1,
            }
        }
        pairs
    }

    /// Number of pairs.
    pub fn total(&self) -> u64 {
        self.both + self.only_first + self.only_second + self.neither
    }

    /// Difference of the proportions of success, first minus second, and Newcombe's interval for paired
    /// data (Newcombe 1998, Statistics in Medicine 17:2635, method 10).
    pub fn difference(&self, confidence: f64) -> (f64, Interval) {
        let n = self.total();
        hybrid(
            [self.both + self.only_first, n],
            [self.both + self.only_second, n],
            self.correlation(),
            confidence,
        )
    }

    /// The phi coefficient with Newcombe's continuity correction.
    fn correlation(&self) -> f64 {
        let [e, f, g, h] =
            [self.both, self.only_first, self.only_second, self.neither].map(|count| count as f64);
        let product = (e + f) * (g + h) * (e + g) * (f + h);
        if product == 0.0 {
            return 0.0;
        }
        let covariance = e * h - f * g;
        let corrected =
            if covariance > 0.0 { (covariance - self.total() as f64 / 2.0).max(0.0) } else { covariance };
        corrected / libm::sqrt(product)
    }
}

/// The interval from the two Wilson intervals and the correlation of the outcomes.
fn hybrid(first: [u64; 2], second: [u64; 2], correlation: f64, confidence: f64) -> (f64, Interval) {
    let share = |[x, n]: [u64; 2]| if n == 0 { 0.0 } else { x as f64 / n as f64 };
    let (p, q) = (share(first), share(second));
    let (a, b) = (wilson(first[0], first[1], confidence), wilson(second[0], second[1], confidence));
    let reach =
        |one: f64, two: f64| libm::sqrt((one * one + two * two - 2.0 * correlation * one * two).max(0.0));
    let low = p - q - reach(p - a.low, b.high - q);
    let high = p - q + reach(a.high - p, q - b.low);
    (p - q, Interval { low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded((difference, interval): (f64, Interval)) -> [f64; 3] {
        [difference, interval.low, interval.high].map(|x| (x * 1e4).round() / 1e4)
    }

    #[test]
    fn independent_differences_agree_with_newcombes_table() {
        // Newcombe 1998, Statistics in Medicine 17:873, table II, method 10.
        assert_eq!(rounded(independent([56, 70], [48, 80], 0.95)), [0.2, 0.0524, 0.3339]);
        assert_eq!(rounded(independent([9, 10], [3, 10], 0.95)), [0.6, 0.1705, 0.8090]);
        assert_eq!(rounded(independent([10, 10], [0, 10], 0.95)), [1.0, 0.6075, 1.0]);
    }

    #[test]
    fn experiment_7_differs_by_2_6_points_for_these_two_policies() {
        let [difference, low, high] = rounded(independent([3604, 4870], [3477, 4870], 0.95));
        assert_eq!([difference, low, high].map(|x| (x * 1e3).round() / 1e3), [0.026, 0.008, 0.044]);
    }

    #[test]
    fn paired_differences_agree_with_newcombes_table() {
        // Newcombe 1998, Statistics in Medicine 17:2635, table II, method 10.
        let pairs = Pairs { both: 36, only_first: 12, only_second: 2, neither: 0 };
        assert_eq!(rounded(pairs.difference(0.95)), [0.2, 0.0569, 0.3404]);
        let none = Pairs { both: 0, only_first: 0, only_second: 0, neither: 54 };
        assert_eq!(rounded(none.difference(0.95)), [0.0, -0.0664, 0.0664]);
    }

    #[test]
    fn pairs_are_counted_by_outcome() {
        let pairs = Pairs::count(&[true, true, false, false, true], &[true, false, true, false, false]);
        assert_eq!(pairs, Pairs { both: 1, only_first: 2, only_second: 1, neither: 1 });
    }
}
