//! The evaluation protocol `episodes`.

use super::{COMMAND, TIME_LIMIT};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "episodes",
    since: Edition::ONE,
    doc: include_str!("episodes.md"),
    params: &[
        Param::default("episodes", Ty::Count, "32").range(1.0, 1e5).doc("Number of episodes."),
        COMMAND,
        TIME_LIMIT,
        Param::default("perturbation", Ty::Quantity(Dimension::ANGLE), "\"0.01 rad\"")
            .range(0.0, 1.0)
            .doc("Standard deviation of the joint positions about the default pose at the start."),
        Param::default("randomize", Ty::Flag, "false")
            .doc("Whether the training's randomization is drawn per episode."),
        Param::default("noise", Ty::Flag, "false").doc("Whether the observation carries its noise."),
        Param::default("seed", Ty::Count, "1000").doc("Names the streams of all episodes; training uses others."),
    ],
    needs: &[],
};
