//! The task kind `walk`.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "walk",
    since: Edition::ONE,
    doc: include_str!("walk.md"),
    params: &[
        Param::required("motion", Ty::Text).doc("The reference motion: a file of `specs/motions/` without its ending."),
        Param::required("episode", Ty::Quantity(Dimension::TIME)).range(0.01, 1e5).doc("Time limit of an episode."),
        Param::required(
            "command",
            Ty::Table(&[
                Param::required("speed", Ty::Sampler(Dimension::VELOCITY))
                    .range(-10.0, 10.0)
                    .doc("Commanded forward speed."),
                Param::optional("every", Ty::Quantity(Dimension::TIME))
                    .range(1e-3, 1e6)
                    .doc("Time between two draws of the speed; without it one draw holds for the episode."),
                Param::default("ramp", Ty::Quantity(Dimension::TIME), "\"0 s\"")
                    .range(0.0, 1e6)
                    .doc("Time over which a new speed is approached linearly."),
            ]),
        )
        .doc("The commanded speed."),
    ],
    needs: &[Signal::Reference],
};
