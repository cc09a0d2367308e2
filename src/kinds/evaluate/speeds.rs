//! The evaluation protocol `speeds`.

use super::{CONTACT_TIME, ENGINE, EXPLORE, NOISE, PERTURBATION, RANDOMIZE, RATE, SEED, TERRAIN, TIME_LIMIT};
use crate::kinds::fine_tune::POLICY;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Section, Ty};

const SPEED: Ty = Ty::Quantity(Dimension::VELOCITY);

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "speeds",
    since: Edition::ONE,
    doc: include_str!("speeds.md"),
    params: &[
        Param::optional("from", SPEED).range(-10.0, 10.0).doc("The lowest speed of the grid."),
        Param::optional("to", SPEED).range(-10.0, 10.0).doc("The highest speed of the grid."),
        Param::optional("step", SPEED).range(1e-3, 10.0).doc("How far apart the speeds of the grid are."),
        Param::optional("speeds", Ty::List(&SPEED))
            .range(-10.0, 10.0)
            .length(Length::Some)
            .doc("Speeds beside or in place of the grid."),
        Param::default("repeats", Ty::Count, "1").range(1.0, 1e4).doc("Episodes at each speed."),
        TIME_LIMIT,
        POLICY,
        TERRAIN,
        PERTURBATION,
        RANDOMIZE,
        NOISE,
        EXPLORE,
        SEED,
        ENGINE,
        RATE,
        CONTACT_TIME,
    ],
    needs: &[],
};

/// The speeds of a decoded table in m/s, rising, each once: those of the grid and those of the list.
pub fn grid(section: Section) -> Vec<f64> {
    let ends = [section.si_if("from"), section.si_if("to"), section.si_if("step")];
    let mut speeds = match ends {
        [Some(from), Some(to), Some(step)] => between([from, to], step),
        _ => Vec::new(),
    };
    if section.has("speeds") {
        speeds.extend(section.numbers("speeds").into_iter().map(rounded));
    }
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds
}

/// The numbers from one end to the other, both included.
fn between([from, to]: [f64; 2], step: f64) -> Vec<f64> {
    let steps = ((to - from) / step).round().max(0.0) as usize;
    (0..=steps).map(|index| rounded(from + index as f64 * step)).collect()
}

/// A speed to the nanometre per second: a sum of steps that should be 0.3 is 0.3.
fn rounded(speed: f64) -> f64 {
    (speed * 1e9).round() / 1e9
}
