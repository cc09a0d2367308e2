//! The test `welch`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind { name: "welch", since: Edition::ONE, doc: include_str!("welch.md"), params: &[], needs: &[] },
    method: Method::Welch,
    unit: Unit::Seed,
    arms: Arms::OneOrTwo,
    takes: &[Scale::Success, Scale::Real],
    least: least::student,
};
