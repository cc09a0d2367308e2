//! The power of a claim's test at the effect and the spread between runs that the claim states.

use super::power::{Arm, MOST_RUNS, TARGET, detectable, of_arms, runs_needed};
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
        let is_of_means = test.unit() == Unit::Seed && !matches!(claim.over, Some(Over::Trend(_)));
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

    /// The distance beyond the boundary at which the power of so many runs per arm is [`TARGET`].
    pub fn detectable(&self, runs: usize, level: f64) -> Option<f64> {
        detectable(self.spreads.as_deref()?, runs, level)
    }

    /// The runs per arm with which one comparison has the power [`TARGET`]; `None` where the effect does not
    /// lie beyond the boundary.
    pub fn runs_needed(&self, level: f64) -> Option<usize> {
        let distance = self.distance.filter(|distance| *distance > 0.0)?;
        runs_needed(distance, self.spreads.as_deref()?, level)
    }

    /// The power of one comparison whose sides have these numbers of runs.
    fn of_comparison(&self, runs: &[usize], level: f64) -> Option<f64> {
        // Which side is multiplied does not depend on which is written first.
        let sides = runs.iter().zip(self.spreads.as_deref()?);
        let arms: Vec<Arm> = sides.map(|(runs, spread)| Arm { spread: *spread, runs: *runs }).collect();
        let power = of_arms(self.distance?, &arms, level)?;
        let is_range = self.claim.expect.relation == Relation::Equal;
        // Both ends of a range must be exceeded.
        Some(if is_range { (2.0 * power - 1.0).max(0.0) } else { power })
    }

    /// The chance of a PASS, given the runs of every arm by its place: where every comparison must pass, the
    /// product of theirs, the least that it can be, which it is for comparisons that share no arm.
    pub fn power(&self, cases: &[Case], runs: impl Fn(usize) -> usize, level: f64) -> Option<f64> {
        let of_case = |case: &Case| {
            let arms = [Some(case.a), case.b.filter(|_| self.claim.sides.len() == 2)];
            let runs: Vec<usize> = arms.into_iter().flatten().map(&runs).collect();
            self.of_comparison(&runs, level)
        };
        match self.claim.over {
            _ if cases.is_empty() => None,
            None | Some(Over::Each) => {
                cases.iter().map(of_case).collect::<Option<Vec<f64>>>().map(|powers| powers.iter().product())
            }
            _ => cases.first().and_then(of_case),
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
