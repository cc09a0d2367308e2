//! The observation `base_orientation`.

use super::{Input, ObserveKind, Readings, Subject, spread};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: ObserveKind = ObserveKind {
    kind: Kind {
        name: "base_orientation",
        since: Edition::ONE,
        doc: include_str!("base_orientation.md"),
        params: &[
            Param::default(
                "scale",
                Ty::List(&Ty::Quantity(Dimension::ANGLE)),
                "[\"0.1 rad\", \"0.1 rad\", \"0.2 rad\"]",
            )
            .range(1e-9, 1e9)
            .length(Length::OneOrEach(&["roll", "pitch", "yaw"]))
            .doc("What becomes 1 after normalisation, for roll, pitch, yaw; one number stands for all."),
            Param::default("clip", Ty::Number, "8.0")
                .range(1e-3, 1e6)
                .doc("Bound of the normalised numbers, both signs."),
        ],
        needs: &[Signal::BaseOrientation],
    },
    inputs,
    read,
};

fn inputs(section: Section, _subject: &Subject) -> Vec<Input> {
    let scales = spread(&section.numbers("scale"), 3);
    let names = ["base_roll", "base_pitch", "base_yaw"];
    let input = |(name, scale): (&str, f64)| Input {
        name: name.into(),
        joint: None,
        unit: "rad".into(),
        offset: 0.0,
        scale,
        clip: section.si("clip"),
    };
    names.into_iter().zip(scales).map(input).collect()
}

fn read(readings: &Readings, index: usize) -> f64 {
    readings.attitude[index]
}
