//! The observation `phase`.

use super::{Input, Observed, Readings, Subject};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Phase = "phase", needs [Phase] {
        /// Value that is normalised to 1.
        #[range(1e-9, 1e9)]
        #[default("0.7")]
        scale: f64,
        /// Bound on the normalised numbers, both signs.
        #[range(1e-3, 1e6)]
        #[default("8.0")]
        clip: f64,
    }
}

impl Observed for Phase {
    fn inputs(&self, _subject: &Subject) -> Vec<Input> {
        let input = |name: &str| Input {
            name: name.into(),
            joint: None,
            unit: "1".into(),
            offset: 0.0,
            scale: self.scale,
            clip: self.clip,
        };
        vec![input("phase_sin"), input("phase_cos")]
    }

    fn read(readings: &Readings, index: usize) -> f64 {
        let angle = std::f64::consts::TAU * readings.phase;
        if index == 0 { libm::sin(angle) } else { libm::cos(angle) }
    }
}
