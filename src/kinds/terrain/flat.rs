//! The terrain kind `flat`.

use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "flat",
    since: Edition::ONE,
    doc: include_str!("flat.md"),
    params: &[Param::required("friction", Ty::Number)
        .range(0.0, 10.0)
        .doc("Coulomb friction coefficient between ground and feet.")],
    needs: &[],
};
