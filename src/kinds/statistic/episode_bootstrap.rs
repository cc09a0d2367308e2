//! The test `episode_bootstrap`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind {
        name: "episode_bootstrap",
        since: Edition::ONE,
        doc: include_str!("episode_bootstrap.md"),
        params: &[],
        needs: &[],
    },
    method: Method::EpisodeBootstrap,
    unit: Unit::Episode,
    arms: Arms::OneOrTwo,
    takes: &[Scale::Success, Scale::Real],
    least: least::one,
};
