//! The test `probability_of_improvement`. What it computes stands in `statistics/`.

use super::{Arms, Method, StatisticKind, Unit, least};
use crate::kinds::metric::Scale;
use crate::spec::{Edition, Kind};

/// The registry entry.
pub static KIND: StatisticKind = StatisticKind {
    kind: Kind {
        name: "probability_of_improvement",
        since: Edition::ONE,
        doc: include_str!("probability_of_improvement.md"),
        params: &[],
        needs: &[],
    },
    method: Method::ProbabilityOfImprovement,
    unit: Unit::Seed,
    arms: Arms::Two,
    takes: &[Scale::Success, Scale::Real, Scale::Censored],
    least: least::ten,
};
