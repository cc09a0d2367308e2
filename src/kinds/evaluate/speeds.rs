//! The evaluation protocol `speeds`.

use super::{Setting, Spread};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Speeds in "evaluate" = "speeds" {
        /// The lowest speed of the grid.
        #[range(-10.0, 10.0)]
        from: Option<Quantified<MetrePerSecond>>,
        /// The highest speed of the grid.
        #[range(-10.0, 10.0)]
        to: Option<Quantified<MetrePerSecond>>,
        /// Step of the grid.
        #[range(1e-3, 10.0)]
        step: Option<Quantified<MetrePerSecond>>,
        /// A list of speeds, in addition to the grid or instead of it.
        #[range(-10.0, 10.0)]
        #[length(Length::Some)]
        speeds: Option<Vec<Quantified<MetrePerSecond>>>,
        /// Episodes at each speed.
        #[range(1.0, 1e4)]
        #[default("1")]
        repeats: u64,
        ..spread: Spread,
        ..setting: Setting,
    }
}

impl Speeds {
    /// The speeds in m/s in ascending order without repetitions: those of the grid and those of the list.
    pub fn grid(&self) -> Vec<f64> {
        let mut speeds = match [self.from, self.to, self.step] {
            [Some(from), Some(to), Some(step)] => between([from, to], step),
            _ => Vec::new(),
        };
        speeds.extend(self.speeds.iter().flatten().copied().map(rounded));
        speeds.sort_by(f64::total_cmp);
        speeds.dedup();
        speeds
    }
}

/// The numbers from one end to the other, including both.
fn between([from, to]: [f64; 2], step: f64) -> Vec<f64> {
    let steps = ((to - from) / step).round().max(0.0) as usize;
    (0..=steps).map(|index| rounded(from + index as f64 * step)).collect()
}

/// Rounds a speed to a nanometre per second, so that a sum of steps gives exactly 0.3.
fn rounded(speed: f64) -> f64 {
    (speed * 1e9).round() / 1e9
}
