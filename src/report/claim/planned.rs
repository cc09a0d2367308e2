//! What the tests of a suite's claims can decide, before there are runs.

use serde::Serialize;

use crate::kinds::metric::{self, MetricKind};
use crate::kinds::statistic::{self, Unit};
use crate::report::wording::number;
use crate::spec::claim::cases::matching;
use crate::spec::claim::{Claim, Over, Points, Relation};
use crate::statistics::power::{alike_runs_needed, detectable, of_means, runs_needed};
use crate::statistics::region::Region;

/// A claim's test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Planned {
    /// The claim.
    pub id: String,
    /// Its test.
    pub test: String,
    /// Seeds per arm.
    pub seeds: usize,
    /// `run` or `episode`.
    pub unit: &'static str,
    /// The level of its smallest p value after Holm's correction for all claims of the suite.
    pub level: f64,
    /// The unit of the metric; `%` for shares, which are numbers between 0 and 1 here.
    pub metric_unit: &'static str,
    /// How far beyond the boundary the truth must lie for a power of 80 %, at the claim's `spread`.
    pub detects: Option<f64>,
    /// The power at the claim's `effect` and `spread`.
    pub power: Option<f64>,
    /// The seeds per arm for a power of 80 %.
    pub seeds_needed: Option<usize>,
    /// The seeds per arm that decide arms whose runs are all alike.
    pub seeds_needed_alike: Option<usize>,
}

/// The tests of the claims of a suite whose arms have so many seeds; a claim has those of the arm that has the fewest.
pub fn planned(claims: &[Claim], arms: &[(&Points, usize)]) -> Vec<Planned> {
    let level = |claim: &Claim| claim.alpha / claims.len().max(1) as f64;
    let points: Vec<&Points> = arms.iter().map(|(points, _)| *points).collect();
    let seeds = |claim: &Claim| {
        let matched = claim.sides.values().flat_map(|pattern| matching(pattern, &points));
        matched.map(|arm| arms[arm].1).min().unwrap_or(1)
    };
    claims.iter().filter_map(|claim| one(claim, seeds(claim), level(claim))).collect()
}

fn one(claim: &Claim, seeds: usize, level: f64) -> Option<Planned> {
    let (metric, test) = (metric::find(&claim.metric.name)?, statistic::find(&claim.test)?);
    let of_runs = test.unit() == Unit::Seed;
    let spread = claim
        .spread
        .as_ref()
        .map(|spread| spread.si)
        .filter(|_| of_runs && !matches!(claim.over, Some(Over::Trend(_))));
    let spreads = spread.map(|spread| match claim.sides.len() {
        1 => vec![spread],
        _ => vec![spread, claim.expect.factor * spread],
    });
    let effect = claim.effect.as_ref().map(|effect| effect.si);
    let region = Region::of(claim, test);
    // How far the expected truth lies beyond the boundary that it must exceed.
    let distance = effect.map(|effect| match region.bounds() {
        (Some(low), Some(high)) => (effect - low).min(high - effect),
        (Some(low), None) => effect - low,
        (None, Some(high)) => high - effect,
        (None, None) => 0.0,
    });
    let both = spreads.as_deref().zip(distance);
    let is_range = claim.expect.relation == Relation::Equal;
    let power = both.and_then(|(spreads, distance)| of_means(distance, spreads, seeds, level));
    Some(Planned {
        id: claim.id.clone(),
        test: claim.test.clone(),
        seeds,
        unit: if of_runs { "run" } else { "episode" },
        level,
        metric_unit: unit(claim, metric),
        detects: spreads.as_deref().and_then(|spreads| detectable(spreads, seeds, level)),
        // Both ends of a range must be exceeded.
        power: power.map(|power| if is_range { (2.0 * power - 1.0).max(0.0) } else { power }),
        seeds_needed: both
            .filter(|(_, distance)| *distance > 0.0)
            .and_then(|(spreads, distance)| runs_needed(distance, spreads, level)),
        seeds_needed_alike: alike_runs_needed(level).filter(|_| of_runs && claim.sides.len() == 2),
    })
}

fn unit(claim: &Claim, metric: &MetricKind) -> &'static str {
    if claim.baseline.as_ref().is_some_and(|baseline| baseline.relative) { "" } else { metric.unit }
}

impl Planned {
    /// Its cells in the table of a plan: claim, test, n, level, what it detects, power, seeds for 80 %.
    pub fn cells(&self) -> [String; 7] {
        let absent = || "-".to_owned();
        let amount = |value: f64| match self.metric_unit {
            "%" => format!("{} points", number(100.0 * value)),
            "" => number(value),
            unit => format!("{} {unit}", number(value)),
        };
        let n = match self.unit {
            "run" => format!("{} seeds", self.seeds),
            _ => format!("{} policies", self.seeds),
        };
        [
            self.id.clone(),
            self.test.clone(),
            n,
            number(self.level),
            self.detects.map_or_else(absent, amount),
            self.power.map_or_else(absent, |power| format!("{} %", number(100.0 * power))),
            self.seeds_needed.map_or_else(absent, |seeds| seeds.to_string()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Quantity;
    use crate::spec::claim::tests::sample;

    #[test]
    fn the_power_of_a_claim_is_that_of_its_effect_and_spread() {
        let quantity = |si: f64| Some(Quantity { si, text: si.to_string() });
        let claim = |effect: f64| Claim {
            margin: quantity(0.2),
            effect: quantity(effect),
            spread: quantity(0.1),
            ..sample("control=torque", Some("control=position"))
        };
        let arms = ["torque", "position"].map(|control| vec![("control".to_owned(), control.to_owned())]);
        let with = |claims: &[Claim], seeds: [usize; 2]| {
            let arms: Vec<(&Points, usize)> = arms.iter().map(Vec::as_slice).zip(seeds).collect();
            planned(claims, &arms)
        };
        let plan = |effect: f64, seeds: usize| with(&[claim(effect)], [seeds; 2]).remove(0);
        assert_eq!(with(&[claim(0.3)], [5, 3])[0].seeds, 3, "the arm with the fewest seeds decides");
        // Two standard deviations beyond the margin, 17 runs for one.
        assert!(plan(0.3, 17).power.is_some_and(|power| (power - 0.8).abs() < 0.01), "{:?}", plan(0.3, 17));
        assert_eq!(plan(0.3, 3).seeds_needed, Some(17));
        assert!(plan(0.3, 17).detects.is_some_and(|distance| (distance - 0.1).abs() < 0.002));
        assert!(plan(0.1, 17).power.is_some_and(|power| power < 0.001), "the effect is on the other side");
        assert_eq!(plan(0.1, 17).seeds_needed, None);
        // Two claims share the level.
        assert_eq!(with(&[claim(0.3), claim(0.3)], [5; 2])[0].level, 0.025);
        let unknown = with(&[sample("control=torque", None)], [5; 2]).remove(0);
        assert_eq!((unknown.power, unknown.detects), (None, None));
    }
}
