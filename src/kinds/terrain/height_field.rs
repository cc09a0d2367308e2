//! The terrain kind `height_field`, and the largest possible field.

use crate::quantity::number;
use crate::spec::typed::prelude::*;

kind! {
    pub struct HeightField = "height_field" {
        /// Coulomb friction coefficient between ground and feet.
        #[range(0.0, 10.0)]
        friction: f64,
        /// Largest height.
        #[range(0.0, 1.0)]
        amplitude: Quantified<Metre>,
        /// Side of a grid cell.
        #[range(0.01, 10.0)]
        #[default("\"0.1 m\"")]
        cell: Quantified<Metre>,
        /// Extent along x, centred on the start.
        #[range(1.0, 1e3)]
        #[default("\"24 m\"")]
        length: Quantified<Metre>,
        /// Extent along y, centred on the start.
        #[range(1.0, 1e3)]
        #[default("\"6 m\"")]
        width: Quantified<Metre>,
        /// Half side of the level square at the start.
        #[range(0.0, 1e3)]
        #[default("\"0.4 m\"")]
        start: Quantified<Metre>,
        /// Seed of the random heights.
        #[default("1")]
        seed: u64,
    }
}

/// Largest number of points: 16 MB of heights, which take seconds to write and read as MJCF.
const MOST_POINTS: f64 = 2e6;

/// Why a field cannot have this size.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SizeError {
    message: String,
    /// The fix.
    pub help: &'static str,
}

/// Checks that a field has at least one cell each way and at most two million points, before it is created.
/// The side of a cell and the extents along x and y are in m.
pub fn check_size(cell: f64, length: f64, width: f64) -> Result<(), SizeError> {
    let points = |extent: f64| (extent / cell).round() + 1.0;
    let [along, across] = [length, width].map(points);
    let [cell, length, width] = [cell, length, width].map(number);
    if along.min(across) < 2.0 {
        let message = format!("a cell of {cell} m is larger than the field of {length} m by {width} m");
        let help =
            "a field has at least one cell along x and along y: make `cell` smaller or the field larger";
        return Err(SizeError { message, help });
    }
    if along * across > MOST_POINTS {
        let (along, across) = (number(along), number(across));
        let message = format!(
            "a field of {along} by {across} points is too large, at most {MOST_POINTS:.0} are possible"
        );
        return Err(SizeError { message, help: "make `cell` larger, or `length` and `width` smaller" });
    }
    Ok(())
}
