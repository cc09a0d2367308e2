//! The observation `phase`.

use super::{Input, ObserveKind, Readings, Subject};
use crate::spec::{Edition, Kind, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: ObserveKind = ObserveKind {
    kind: Kind {
        name: "phase",
        since: Edition::ONE,
        doc: include_str!("phase.md"),
        params: &[
            Param::default("scale", Ty::Number, "0.7").range(1e-9, 1e9).doc("What becomes 1 after normalisation."),
            Param::default("clip", Ty::Number, "8.0")
                .range(1e-3, 1e6)
                .doc("Bound of the normalised numbers, both signs."),
        ],
        needs: &[Signal::Phase],
    },
    inputs,
    read,
};

fn inputs(section: Section, _subject: &Subject) -> Vec<Input> {
    let input = |name: &str| Input {
        name: name.into(),
        joint: None,
        unit: "1".into(),
        offset: 0.0,
        scale: section.si("scale"),
        clip: section.si("clip"),
    };
    vec![input("phase_sin"), input("phase_cos")]
}

fn read(readings: &Readings, index: usize) -> f64 {
    let angle = std::f64::consts::TAU * readings.phase;
    if index == 0 { libm::sin(angle) } else { libm::cos(angle) }
}
