//! The evaluation protocol `speeds`.

use super::{CONTACT_TIME, ENGINE, NOISE, PERTURBATION, RANDOMIZE, RATE, SEED, TERRAIN, TIME_LIMIT};
use crate::kinds::fine_tune::POLICY;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

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
        Param::optional("speeds", Ty::List(&SPEED)).range(-10.0, 10.0).doc("Speeds beside or in place of the grid."),
        Param::default("repeats", Ty::Count, "1").range(1.0, 1e4).doc("Episodes at each speed."),
        TIME_LIMIT,
        POLICY,
        TERRAIN,
        PERTURBATION,
        RANDOMIZE,
        NOISE,
        SEED,
        ENGINE,
        RATE,
        CONTACT_TIME,
    ],
    needs: &[],
};
