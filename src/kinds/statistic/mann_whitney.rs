//! The test `mann_whitney`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind {
        name: "mann_whitney",
        since: Edition::ONE,
        doc: include_str!("mann_whitney.md"),
        params: &[],
        needs: &[],
    },
    method: Method::MannWhitney,
    unit: Unit::Seed,
    arms: Arms::Two,
    takes: &[Scale::Success, Scale::Real, Scale::Censored],
    least: least::ranks,
};
