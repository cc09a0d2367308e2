//! The course of a training in a few characters: `▁▂▃▅▇████······`.

/// Heights of a character.
const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// Work still to be done.
const AHEAD: char = '·';

/// A quantity over the course of a stage, in cells of equal width.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Sum and number of the values in each cell.
    cells: Vec<(f64, u32)>,
}

impl Curve {
    /// A curve of this many characters.
    pub fn new(width: usize) -> Self {
        Self { cells: vec![(0.0, 0); width.max(1)] }
    }

    /// Adds a value measured when this share of the work, in (0, 1], was done.
    pub fn add(&mut self, share: f64, value: f64) {
        if value.is_finite() {
            let last = self.cells.len() - 1;
            let place = (share * self.cells.len() as f64).ceil() as usize;
            let (sum, count) = &mut self.cells[place.saturating_sub(1).min(last)];
            (*sum, *count) = (*sum + value, *count + 1);
        }
    }

    /// The curve, scaled from zero (or its minimum, if negative) to its maximum. Cells without values, from
    /// before the work was resumed, are blank.
    pub fn blocks(&self) -> String {
        let means: Vec<Option<f64>> =
            self.cells.iter().map(|(sum, count)| (*count > 0).then(|| sum / f64::from(*count))).collect();
        let known = || means.iter().flatten().copied();
        let (low, high) = (known().fold(0.0, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
        let Some(end) = means.iter().rposition(Option::is_some) else {
            return AHEAD.to_string().repeat(means.len());
        };
        let block = |value: f64| {
            let share = if high > low { (value - low) / (high - low) } else { 0.0 };
            BLOCKS[((share * BLOCKS.len() as f64) as usize).min(BLOCKS.len() - 1)]
        };
        let mut shown = ' ';
        let cell = |(place, mean): (usize, &Option<f64>)| {
            shown = if place > end { AHEAD } else { mean.map_or(shown, block) };
            shown
        };
        means.iter().enumerate().map(cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_fills_from_the_left_and_scales_to_its_greatest_value() {
        let mut curve = Curve::new(8);
        assert_eq!(curve.blocks(), "········");
        for update in 1..=8 {
            curve.add(f64::from(update) / 16.0, f64::from(update));
        }
        // Means of 1.5, 3.5, 5.5 and 7.5 against 7.5.
        assert_eq!(curve.blocks(), "▂▄▆█····");
        curve.add(1.0, 7.5);
        assert_eq!(curve.blocks(), "▂▄▆████".to_owned() + "█");
    }

    #[test]
    fn a_resumed_curve_is_blank_before_and_values_below_zero_are_low() {
        let mut curve = Curve::new(4);
        curve.add(0.75, -2.0);
        curve.add(1.0, 2.0);
        curve.add(1.0, f64::NAN);
        assert_eq!(curve.blocks(), "  ▁█");
        let mut flat = Curve::new(2);
        flat.add(0.5, 0.0);
        assert_eq!(flat.blocks(), "▁·");
    }
}
