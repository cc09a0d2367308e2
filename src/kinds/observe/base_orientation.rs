//! The observation `base_orientation`.

use super::{Input, Observed, Readings, Subject, spread};
use crate::spec::typed::prelude::*;

kind! {
    pub struct BaseOrientation = "base_orientation", needs [BaseOrientation] {
        /// Values that are normalised to 1, for roll, pitch, yaw; a single number applies to all.
        #[range(1e-9, 1e9)]
        #[length(Length::OneOrEach(&["roll", "pitch", "yaw"]))]
        #[default("[\"0.1 rad\", \"0.1 rad\", \"0.2 rad\"]")]
        scale: Vec<Quantified<Radian>>,
        /// Bound on the normalised numbers, both signs.
        #[range(1e-3, 1e6)]
        #[default("8.0")]
        clip: f64,
    }
}

impl Observed for BaseOrientation {
    fn inputs(&self, _subject: &Subject) -> Vec<Input> {
        let scales = spread(&self.scale, 3);
        let names = ["base_roll", "base_pitch", "base_yaw"];
        let input = |(name, scale): (&str, f64)| Input {
            name: name.into(),
            joint: None,
            unit: "rad".into(),
            offset: 0.0,
            scale,
            clip: self.clip,
        };
        names.into_iter().zip(scales).map(input).collect()
    }

    fn read(readings: &Readings, index: usize) -> f64 {
        readings.attitude[index]
    }
}
