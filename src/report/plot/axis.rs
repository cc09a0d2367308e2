//! Axes: range, ticks and tick labels.

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit, for example `episode length (s)`.
    pub label: String,
    /// First and last value.
    pub range: [f64; 2],
    /// Positions and labels of the ticks.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis that covers the finite ones of these values, with about `count` ticks. A range of a single
    /// value is widened; without values the range is 0 to 1.
    pub fn fit(label: impl Into<String>, values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let [mut low, mut high] = bounds(values).unwrap_or([0.0, 1.0]);
        if high - low <= 1e-9 * high.abs().max(low.abs()).max(1e-9) {
            let margin = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
            (low, high) = (low - margin, high + margin);
        }
        Self::over(label, [low, high], count)
    }

    /// [`Axis::fit`] with zero included and the ends rounded outwards to ticks.
    pub fn from_zero(label: impl Into<String>, values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let fitted = Self::fit(label, values.into_iter().chain([0.0]), count);
        let step = nice_step(fitted.range, count);
        let range = [libm::floor(fitted.range[0] / step) * step, libm::ceil(fitted.range[1] / step) * step];
        Self::over(fitted.label, range, count)
    }

    /// An axis with exactly this range, and ticks at round values within it.
    pub fn over(label: impl Into<String>, range: [f64; 2], count: usize) -> Self {
        let step = nice_step(range, count);
        let decimals = (-libm::floor(libm::log10(step) + 1e-9)).max(0.0) as usize;
        let (first, last) = (libm::ceil(range[0] / step - 1e-9), libm::floor(range[1] / step + 1e-9));
        let ticks = (0..)
            .map(|index| first + f64::from(index))
            .take_while(|place| *place <= last)
            .map(|place| (place * step, written(place * step, decimals)))
            .collect();
        Self { label: label.into(), range, ticks }
    }

    /// The same axis without labels, for all but the lowest of stacked panels.
    pub fn without_words(&self) -> Self {
        let ticks = self.ticks.iter().map(|(value, _)| (*value, String::new())).collect();
        Self { label: String::new(), range: self.range, ticks }
    }

    /// Relative position of a value: 0 at the start of the range, 1 at its end.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }
}

/// The smallest and largest finite value.
pub fn bounds(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    values.into_iter().filter(|value| value.is_finite()).fold(None, |range: Option<[f64; 2]>, value| {
        let [low, high] = range.unwrap_or([value, value]);
        Some([low.min(value), high.max(value)])
    })
}

/// 1, 2 or 5 times a power of ten, such that the range has about `count` steps.
fn nice_step(range: [f64; 2], count: usize) -> f64 {
    let rough = (range[1] - range[0]).max(1e-12) / count.max(1) as f64;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough * 0.999).unwrap_or(10.0);
    factor * power
}

/// From here on a number is written with an exponent.
const LARGE: f64 = 1e15;

/// A number with this many decimals, a true minus sign and no negative zero; a large one as `1.00e300`.
pub fn written(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let text =
        if size < LARGE || !size.is_finite() { format!("{size:.decimals$}") } else { format!("{size:.2e}") };
    let zero = text.bytes().all(|byte| byte == b'0' || byte == b'.');
    if value < 0.0 && !zero { format!("\u{2212}{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn a_large_number_has_an_exponent_in_place_of_three_hundred_digits() {
        assert_eq!(written(-1e300, 3), "\u{2212}1.00e300");
        assert_eq!(written(1e14, 0), "100000000000000");
        assert_eq!(written(f64::INFINITY, 1), "inf");
    }

    #[test]
    fn ticks_stand_at_round_values() {
        assert_eq!(labels(&Axis::over("", [0.0, 3.1], 4)), ["0", "1", "2", "3"]);
        assert_eq!(
            labels(&Axis::over("", [-0.25, 0.25], 5)),
            ["\u{2212}0.2", "\u{2212}0.1", "0.0", "0.1", "0.2"]
        );
        assert_eq!(labels(&Axis::over("", [0.0, 2500.0], 5)), ["0", "500", "1000", "1500", "2000", "2500"]);
    }

    #[test]
    fn an_axis_from_zero_ends_at_a_tick() {
        let axis = Axis::from_zero("", [1.0, 7.3], 4);
        assert_eq!(axis.range, [0.0, 8.0]);
        assert_eq!(labels(&axis), ["0", "2", "4", "6", "8"]);
    }

    #[test]
    fn one_value_and_none_still_make_an_axis() {
        assert_eq!(Axis::fit("", [2.0, 2.0], 4).range, [1.8, 2.2]);
        assert_eq!(Axis::fit("", [f64::NAN], 4).range, [0.0, 1.0]);
    }
}
