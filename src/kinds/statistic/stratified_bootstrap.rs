//! The test `stratified_bootstrap`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind {
        name: "stratified_bootstrap",
        since: Edition::ONE,
        doc: include_str!("stratified_bootstrap.md"),
        params: &[],
        needs: &[],
    },
    method: Method::StratifiedBootstrap,
    unit: Unit::Seed,
    arms: Arms::OneOrTwo,
    takes: &[Scale::Success, Scale::Real],
    least: least::ten,
};
