//! The terrain kind `height_field`, and how large a field can be.

use crate::quantity::{Dimension, number};
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

/// The most points of a field: 16 MB of heights, and seconds to write and read as MJCF.
const MOST_POINTS: f64 = 2e6;

/// Why there can be no field of this size.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SizeError {
    message: String,
    /// What to do about it.
    pub help: &'static str,
}

/// Checks that a field spans at least one cell each way and has at most two million points, before any of them is made.
/// The side of a cell and the extents along x and y are in m.
pub fn check_size(cell: f64, length: f64, width: f64) -> Result<(), SizeError> {
    let points = |extent: f64| (extent / cell).round() + 1.0;
    let [along, across] = [length, width].map(points);
    let [cell, length, width] = [cell, length, width].map(number);
    if along.min(across) < 2.0 {
        let message = format!("a cell of {cell} m is larger than the field of {length} m by {width} m");
        let help = "a field has at least one cell along x and along y: make `cell` smaller or the field larger";
        return Err(SizeError { message, help });
    }
    if along * across > MOST_POINTS {
        let (along, across) = (number(along), number(across));
        let message =
            format!("a field of {along} by {across} points is too large, at most {MOST_POINTS:.0} are possible");
        return Err(SizeError { message, help: "make `cell` larger, or `length` and `width` smaller" });
    }
    Ok(())
}
