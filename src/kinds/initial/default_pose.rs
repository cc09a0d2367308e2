//! The initial state `default_pose`.

use super::STANDING_NOISE;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "default_pose",
    since: Edition::ONE,
    doc: include_str!("default_pose.md"),
    params: &[
        Param::default("phases", Ty::List(&Ty::Number), "[0.0]")
            .range(0.0, 1.0)
            .doc("Phases to start at, drawn with equal chance; evaluations take them in turn."),
        STANDING_NOISE,
    ],
    needs: &[],
};
