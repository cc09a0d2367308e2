//! The terrain kind `slope`.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "slope",
    since: Edition::ONE,
    doc: include_str!("slope.md"),
    params: &[
        Param::required("friction", Ty::Number)
            .range(0.0, 10.0)
            .doc("Coulomb friction coefficient between ground and feet."),
        Param::required("angle", Ty::Quantity(Dimension::ANGLE))
            .range(-0.6, 0.6)
            .doc("Angle of the incline; positive is uphill."),
    ],
    needs: &[],
};
