//! The deployment kind `transfer`.

use crate::kinds::evaluate::{COMMAND, CONTACT_TIME, DRAWN, EXPLORE, TERRAIN, TIME_LIMIT};
use crate::kinds::fine_tune::POLICY;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "transfer",
    since: Edition::ONE,
    doc: include_str!("transfer.md"),
    params: &[
        Param::required("engine", Ty::Choice(&["rapier", "mujoco", "batch"])).doc("The engine to run in."),
        Param::required("rate", Ty::Quantity(Dimension::RATE))
            .range(1.0, 1e6)
            .doc("Physics rate; the rates of control must divide it."),
        Param::optional("episodes", Ty::Count).range(1.0, 1e5).doc("Number of episodes."),
        COMMAND,
        TIME_LIMIT,
        POLICY,
        TERRAIN,
        Param::optional("perturbation", Ty::Quantity(Dimension::ANGLE))
            .range(0.0, 1.0)
            .doc("Standard deviation of the joint positions about the default pose at the start."),
        Param::optional("randomize", DRAWN).doc(
            "What is drawn per episode: nothing, with `true` the training's randomization, or the rows of a table.",
        ),
        Param::optional("noise", Ty::Flag).doc("Whether the observation carries its noise."),
        EXPLORE,
        Param::optional("seed", Ty::Count).doc("Names the streams of all episodes."),
        CONTACT_TIME,
    ],
    needs: &[],
};
