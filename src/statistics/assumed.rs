//! The power of a claim's test at the effect and the spread between runs that the claim states.

use super::power::{Arm, MOST_RUNS, TARGET, detectable, of_arms};
use super::region::Region;
use crate::kinds::statistic::{StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Over, Relation};

/// What a claim about means over runs states of the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Assumed<'a> {
    claim: &'a Claim,
    /// The standard deviation between the runs of each side, times the factor of the claim; `None` where the
    /// claim states none, or its test is not about means over runs.
    spreads: Option<Vec<f64>>,
    /// How far the effect lies beyond the boundary that it must exceed, in the metric's unit; `None` where
    /// the claim states no effect.
    distance: Option<f64>,
}

impl<'a> Assumed<'a> {
    /// What a claim states.
    pub fn of(claim: &'a Claim, test: &StatisticKind) -> Self {
        let is_of_means = test.unit() == Unit::Seed;
        let factors = [1.0, claim.expect.factor];
        let of_sides =
            |spread: f64| factors.map(|factor| factor * spread)[..claim.sides.len().min(2)].to_vec();
        let spread = claim.spread.as_ref().filter(|_| is_of_means);
        let beyond = |effect: f64| match Region::of(claim, test).bounds() {
            (Some(low), Some(high)) => (effect - low).min(high - effect),
            (Some(low), None) => effect - low,
            (None, Some(high)) => high - effect,
            (None, None) => 0.0,
        };
        Self {
            claim,
            spreads: spread.map(|spread| of_sides(spread.si)),
            distance: claim.effect.as_ref().map(|effect| beyond(effect.si)),
        }
    }

    /// The distance beyond the boundary at which the power of the claim is [`TARGET`], with so many runs in
    /// every arm.
    pub fn detectable(&self, cases: &[Case], runs: usize, level: f64) -> Option<f64> {
        let scale = self.spreads.as_deref()?.iter().map(|spread| spread * spread).sum();
        detectable(libm::sqrt(scale), |distance| self.at(distance, cases, |_| runs, level))
    }

    /// The chance of a PASS, given the runs of every arm by its place.
    pub fn power(&self, cases: &[Case], runs: impl Fn(usize) -> usize, level: f64) -> Option<f64> {
        self.at(self.distance?, cases, runs, level)
    }

    /// [`Self::power`] if every comparison lies so far beyond its boundary. Where each must pass, the product of
    /// theirs, the least that it can be, which it is for comparisons that share no arm.
    fn at(&self, distance: f64, cases: &[Case], runs: impl Fn(usize) -> usize, level: f64) -> Option<f64> {
        // Which side is multiplied does not depend on which is written first.
        let spreads = self.spreads.as_deref()?;
        let arms = |case: &Case, weight: f64| -> Vec<Arm> {
            let sides = [Some(case.a), case.b].into_iter().flatten().zip(spreads);
            sides.map(|(arm, spread)| Arm { spread: weight * spread, runs: runs(arm) }).collect()
        };
        let power = |arms: &[Arm]| {
            let power = of_arms(distance, arms, level)?;
            let is_range = self.claim.expect.relation == Relation::Equal;
            // Both ends of a range must be exceeded.
            Some(if is_range { (2.0 * power - 1.0).max(0.0) } else { power })
        };
        match self.claim.over {
            _ if cases.is_empty() => None,
            None | Some(Over::Each) => {
                let first = arms(&cases[0], 1.0);
                let of_first = power(&first)?;
                let of_case = |case: &Case| match arms(case, 1.0) {
                    alike if alike == first => Some(of_first),
                    other => power(&other),
                };
                cases.iter().map(of_case).product()
            }
            Some(Over::Mean) => {
                let weight = 1.0 / cases.len() as f64;
                power(&cases.iter().flat_map(|case| arms(case, weight)).collect::<Vec<_>>())
            }
            // A trend, or several tests of which some must pass or fail: not computed.
            Some(_) => None,
        }
    }

    /// The fewest runs in every arm with which the claim has the power [`TARGET`].
    pub fn runs_for_all(&self, cases: &[Case], level: f64) -> Option<usize> {
        let is_enough = |runs: usize| self.power(cases, |_| runs, level).is_some_and(|power| power >= TARGET);
        let (mut too_few, mut enough) = (1, 2);
        while !is_enough(enough) {
            (too_few, enough) = (enough, 2 * enough);
            if too_few >= MOST_RUNS {
                return None;
            }
        }
        while enough - too_few > 1 {
            let middle = too_few.midpoint(enough);
            if is_enough(middle) { enough = middle } else { too_few = middle }
        }
        Some(enough)
    }
}
