//! The terrain kind `box_obstacle`.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "box_obstacle",
    since: Edition::ONE,
    doc: include_str!("box_obstacle.md"),
    params: &[
        Param::required("friction", Ty::Number)
            .range(0.0, 10.0)
            .doc("Coulomb friction coefficient between ground and feet."),
        Param::required("height", Ty::Quantity(Dimension::LENGTH))
            .range(0.0, 1.0)
            .doc("Height of the box above ground."),
        Param::default("length", Ty::Quantity(Dimension::LENGTH), "\"0.4 m\"").range(1e-3, 1e3).doc("Length along x."),
        Param::default("width", Ty::Quantity(Dimension::LENGTH), "\"8 m\"").range(1e-3, 1e3).doc("Width along y."),
        Param::required("distance", Ty::Quantity(Dimension::LENGTH)).range(0.0, 1e3).doc("Distance from the start."),
        Param::default("reference", Ty::Choice(&["front", "center"]), "\"center\"")
            .doc("What of the box is at `distance`."),
    ],
    needs: &[],
};
