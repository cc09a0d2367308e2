//! The failure rate in each tenth of a parameter's values.

use super::Sets;
use crate::statistics::Interval;
use crate::statistics::proportion::wilson;

/// Number of equal parts.
pub const PARTS: usize = 10;

/// A tenth of the sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decile {
    /// Mean deviation from the nominal value, in units of half the range.
    pub place: f64,
    /// Failures and trials.
    pub count: [u64; 2],
    /// The share of failures.
    pub rate: f64,
    /// Wilson's interval.
    pub interval: Interval,
}

/// The tenths of a parameter from its lowest values to its highest; empty if there are fewer than ten sets.
pub fn of(sets: &Sets, parameter: usize, confidence: f64) -> Vec<Decile> {
    let count = sets.rows.len();
    if count < PARTS {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| sets.rows[*a][parameter].total_cmp(&sets.rows[*b][parameter]));
    let part = |at: usize| &order[at * count / PARTS..(at + 1) * count / PARTS];
    (0..PARTS).map(|at| decile(sets, part(at), parameter, confidence)).collect()
}

fn decile(sets: &Sets, part: &[usize], parameter: usize, confidence: f64) -> Decile {
    let sum = |of: &[f64]| libm::round(part.iter().map(|set| of[*set]).sum::<f64>()) as u64;
    let (failures, trials) = (sum(&sets.failures), sum(&sets.trials));
    let place = part.iter().map(|set| sets.rows[*set][parameter]).sum::<f64>() / part.len() as f64;
    Decile {
        place,
        count: [failures, trials],
        rate: failures as f64 / (trials as f64).max(1.0),
        interval: wilson(failures, trials, confidence),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_of_the_highest_values_are_in_the_last_tenth() {
        let rows: Vec<Vec<f64>> = (0..25).map(|set| vec![f64::from((set * 7) % 25) / 12.0 - 1.0]).collect();
        let failures = rows.iter().map(|row| f64::from(u8::from(row[0] > 0.8))).collect();
        let sets = Sets { names: vec!["a".into()], trials: vec![1.0; 25], failures, rows };
        let found = of(&sets, 0, 0.95);
        assert_eq!(found.iter().map(|decile| decile.count[1]).sum::<u64>(), 25);
        assert_eq!(found[9].count, [3, 3]);
        assert!(found[..9].iter().all(|decile| decile.count[0] == 0) && found[0].place < found[9].place);
        assert!(of(&Sets { rows: vec![vec![0.0]; 9], ..sets }, 0, 0.95).is_empty());
    }
}
