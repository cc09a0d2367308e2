//! The test `wilson`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind { name: "wilson", since: Edition::ONE, doc: include_str!("wilson.md"), params: &[], needs: &[] },
    method: Method::Wilson,
    unit: Unit::Episode,
    arms: Arms::One,
    takes: &[Scale::Success],
    least: least::one,
};
