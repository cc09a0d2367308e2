//! The observation `command`.

use super::{Input, ObserveKind, Readings, Subject};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: ObserveKind = ObserveKind {
    kind: Kind {
        name: "command",
        since: Edition::ONE,
        doc: include_str!("command.md"),
        params: &[
            Param::optional("offset", Ty::Quantity(Dimension::VELOCITY))
                .range(-100.0, 100.0)
                .doc("What becomes 0 after normalisation."),
            Param::optional("scale", Ty::Quantity(Dimension::VELOCITY))
                .range(1e-9, 1e9)
                .doc("What becomes 1 above the offset after normalisation."),
            Param::default("clip", Ty::Number, "8.0")
                .range(1e-3, 1e6)
                .doc("Bound of the normalised numbers, both signs."),
        ],
        needs: &[Signal::CommandSpeed],
    },
    inputs,
    read,
};

fn inputs(section: Section, subject: &Subject) -> Vec<Input> {
    let [low, high] = subject.command;
    let half = 0.5 * (high - low);
    let scale = section.si_if("scale").unwrap_or(if half > 0.0 { half } else { 1.0 });
    vec![Input {
        name: "command_speed".into(),
        joint: None,
        unit: "m/s".into(),
        offset: section.si_if("offset").unwrap_or(0.5 * (low + high)),
        scale,
        clip: section.si("clip"),
    }]
}

fn read(readings: &Readings, _: usize) -> f64 {
    readings.command_speed
}
