//! The evaluation protocol `episodes`.

use super::{COMMAND, CONTACT_TIME, ENGINE, EXPLORE, NOISE, PERTURBATION, RANDOMIZE, RATE, SEED, TERRAIN, TIME_LIMIT};
use crate::kinds::fine_tune::POLICY;
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
        POLICY,
        TERRAIN,
        PERTURBATION,
        RANDOMIZE,
        NOISE,
        EXPLORE,
        SEED,
        ENGINE,
        RATE,
        CONTACT_TIME,
    ],
    needs: &[],
};
