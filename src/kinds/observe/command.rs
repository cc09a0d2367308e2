//! The observation `command`.

use super::{Input, Observed, Readings, Subject};
use crate::spec::typed::prelude::*;

kind! {
    pub struct CommandSpeed = "command", needs [CommandSpeed] {
        /// Value that is normalised to 0.
        #[range(-100.0, 100.0)]
        offset: Option<Quantified<MetrePerSecond>>,
        /// Difference from the offset that is normalised to 1.
        #[range(1e-9, 1e9)]
        scale: Option<Quantified<MetrePerSecond>>,
        /// Bound on the normalised numbers, both signs.
        #[range(1e-3, 1e6)]
        #[default("8.0")]
        clip: f64,
    }
}

impl Observed for CommandSpeed {
    fn inputs(&self, subject: &Subject) -> Vec<Input> {
        let [low, high] = subject.command;
        let half = 0.5 * (high - low);
        let scale = self.scale.unwrap_or(if half > 0.0 { half } else { 1.0 });
        vec![Input {
            name: "command_speed".into(),
            joint: None,
            unit: "m/s".into(),
            offset: self.offset.unwrap_or(0.5 * (low + high)),
            scale,
            clip: self.clip,
        }]
    }

    fn read(readings: &Readings, _: usize) -> f64 {
        readings.command_speed
    }
}
