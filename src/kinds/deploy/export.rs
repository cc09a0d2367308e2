//! The deployment kind `export`.

use crate::kinds::fine_tune::POLICY;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "export",
    since: Edition::ONE,
    doc: include_str!("export.md"),
    params: &[
        Param::default("formats", Ty::List(&Ty::Choice(&["safetensors"])), "[\"safetensors\"]")
            .doc("Formats of the artefact."),
        POLICY,
    ],
    needs: &[],
};
