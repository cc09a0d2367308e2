//! The terrain kind `height_field`.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "height_field",
    since: Edition::ONE,
    doc: include_str!("height_field.md"),
    params: &[
        Param::required("friction", Ty::Number)
            .range(0.0, 10.0)
            .doc("Coulomb friction coefficient between ground and feet."),
        Param::required("amplitude", Ty::Quantity(Dimension::LENGTH)).range(0.0, 1.0).doc("Largest height."),
        Param::default("cell", Ty::Quantity(Dimension::LENGTH), "\"0.1 m\"")
            .range(0.01, 10.0)
            .doc("Side of a grid cell."),
        Param::default("length", Ty::Quantity(Dimension::LENGTH), "\"24 m\"")
            .range(1.0, 1e3)
            .doc("Extent along x, centred on the start."),
        Param::default("width", Ty::Quantity(Dimension::LENGTH), "\"6 m\"")
            .range(1.0, 1e3)
            .doc("Extent along y, centred on the start."),
        Param::default("start", Ty::Quantity(Dimension::LENGTH), "\"0.4 m\"")
            .range(0.0, 1e3)
            .doc("Half side of the level square at the start."),
        Param::default("seed", Ty::Count, "1").doc("Names the random heights."),
    ],
    needs: &[],
};
