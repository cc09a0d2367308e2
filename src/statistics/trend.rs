//! The trend of means over ordered points: the slope per point of the least-squares line over equally spaced
//! points with equal weights.

use super::Interval;
use super::proportion::wilson;

/// The coordinates of these points relative to their middle.
fn places(points: usize) -> impl Iterator<Item = f64> {
    let middle = 0.5 * (points as f64 - 1.0);
    (0..points).map(move |point| point as f64 - middle)
}

/// The weights of the points' means in the slope; empty for fewer than two.
pub fn weights(points: usize) -> Vec<f64> {
    let squares: f64 = places(points).map(|place| place * place).sum();
    if squares == 0.0 { Vec::new() } else { places(points).map(|place| place / squares).collect() }
}

/// The slope of values at equally spaced points; `None` for fewer than two. Equal values have a slope of
/// exactly zero, because the coordinates sum to zero without rounding.
pub fn slope(values: &[f64]) -> Option<f64> {
    let squares: f64 = places(values.len()).map(|place| place * place).sum();
    let sum: f64 = places(values.len()).zip(values).map(|(place, value)| place * value).sum();
    (squares > 0.0).then(|| sum / squares)
}

/// The interval of the slope of shares from the Wilson intervals of each point (Zou and Donner 2008; with two
/// points it is Newcombe's hybrid score interval).
pub fn of_shares(counts: &[[u64; 2]], confidence: f64) -> Option<Interval> {
    let weights = weights(counts.len());
    let share = |[successes, trials]: [u64; 2]| successes as f64 / trials as f64;
    let value = slope(&counts.iter().map(|count| share(*count)).collect::<Vec<_>>())?;
    let reach = |downwards: bool| {
        let distance = |(weight, count): (&f64, &[u64; 2])| {
            let ends = wilson(count[0], count[1], confidence);
            let end = if (*weight > 0.0) == downwards { ends.low } else { ends.high };
            weight * (share(*count) - end)
        };
        libm::sqrt(weights.iter().zip(counts).map(distance).map(|distance| distance * distance).sum())
    };
    Some(Interval { low: value - reach(true), high: value + reach(false) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::difference::independent;

    #[test]
    fn the_slope_of_the_papers_table_is_a_tenth_per_halving() {
        // Exp. 5: 15, 18, 22, 22, 25 of 25. By hand: (-2 * 15 - 18 + 22 + 2 * 25) / 10 / 25.
        let shares = [15.0, 18.0, 22.0, 22.0, 25.0].map(|alive| alive / 25.0);
        assert!((slope(&shares).expect("a slope") - 0.096).abs() < 1e-12);
        assert_eq!((slope(&[1.0]), slope(&[])), (None, None));
        assert_eq!(slope(&[1.0, 3.0]), Some(2.0));
    }

    #[test]
    fn the_interval_of_two_points_is_newcombes() {
        let counts = [[12, 20], [15, 16]];
        let ours = of_shares(&counts, 0.95).expect("an interval");
        let (_, newcombe) = independent(counts[1], counts[0], 0.95);
        assert!(
            (ours.low - newcombe.low).abs() < 1e-12 && (ours.high - newcombe.high).abs() < 1e-12,
            "{ours:?}"
        );
        // Five points at which all survive: the slope is zero with a narrow interval.
        let level = of_shares(&[[150, 150]; 5], 0.95).expect("an interval");
        assert!(level.low < 0.0 && level.high > 0.0 && level.high - level.low < 0.03, "{level:?}");
    }
}
