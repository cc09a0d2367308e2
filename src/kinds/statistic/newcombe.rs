//! The test `newcombe`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind { name: "newcombe", since: Edition::ONE, doc: include_str!("newcombe.md"), params: &[], needs: &[] },
    method: Method::Newcombe,
    unit: Unit::Episode,
    arms: Arms::Two,
    takes: &[Scale::Success],
    least: least::one,
};
