//! The region in which a claim expects the estimate, and whether an interval lies in it.

use super::Interval;
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Claim, Operand, Relation};

/// The region in which a claim expects the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// The point of equality: 0, the claim's number or the difference that it adds to an arm, or one half.
    centre: f64,
    relation: Relation,
    /// Distance of the boundary from the centre: the margin, or the tolerance of `==`.
    distance: f64,
}

impl Region {
    /// The region that a claim expects for the estimate of its test.
    pub fn of(claim: &Claim, statistic: &StatisticKind) -> Self {
        let centre = match (&claim.expect.right, statistic.method) {
            (Operand::Number(number), _) => number.si,
            (_, Method::ProbabilityOfImprovement) => 0.5,
            _ => claim.expect.offset.as_ref().map_or(0.0, |offset| offset.si),
        };
        let distance =
            claim.expect.within.as_ref().or(claim.margin.as_ref()).map_or(0.0, |quantity| quantity.si);
        Self { centre, relation: claim.expect.relation, distance }
    }

    /// The point of equality.
    pub fn centre(&self) -> f64 {
        self.centre
    }

    /// The region between two boundaries, of which one may be absent; `None` without any.
    pub fn between(bounds: [Option<f64>; 2]) -> Option<Self> {
        let (centre, relation, distance) = match bounds {
            [Some(low), Some(high)] => (0.5 * (low + high), Relation::Equal, 0.5 * (high - low)),
            [Some(low), None] => (low, Relation::Greater, 0.0),
            [None, Some(high)] => (high, Relation::Less, 0.0),
            [None, None] => return None,
        };
        Some(Self { centre, relation, distance })
    }

    /// A number inside the region or at its end: the boundary, or the middle of a range.
    pub fn boundary(&self) -> f64 {
        match self.bounds() {
            (Some(bound), None) | (None, Some(bound)) => bound,
            _ => self.centre,
        }
    }

    /// Two-sided p value for the claim: for the boundary that the estimate must exceed, or for a range the
    /// larger one of both boundaries (two one-sided tests); 1 if the estimate is outside. `p` is the p value
    /// for the true value being a given number.
    pub fn p_for(&self, value: f64, p: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        let (low, high) = self.bounds();
        let low = low.map(|low| if value > low { p(low) } else { Some(1.0) });
        let high = high.map(|high| if value < high { p(high) } else { Some(1.0) });
        [low, high].into_iter().flatten().try_fold(0.0, |largest: f64, p| Some(largest.max(p?)))
    }

    /// Two-sided p value for the opposite: the estimate lies on the other side of a boundary.
    pub fn p_against(&self, value: f64, p: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        let (low, high) = self.bounds();
        let low = low.filter(|low| value < *low);
        let high = high.filter(|high| value > *high);
        low.or(high).map_or(Some(1.0), p)
    }

    /// The lower boundary of the region, if it has one, and the upper.
    pub fn bounds(&self) -> (Option<f64>, Option<f64>) {
        let (centre, distance) = (self.centre, self.distance);
        match self.relation {
            Relation::Greater => (Some(centre + distance), None),
            Relation::AtLeast => (Some(centre - distance), None),
            Relation::Less => (None, Some(centre - distance)),
            Relation::AtMost => (None, Some(centre + distance)),
            Relation::Equal => (Some(centre - distance), Some(centre + distance)),
        }
    }

    /// Whether the whole interval lies in the region; touching a boundary counts as inside.
    pub fn holds(&self, interval: Interval) -> bool {
        let (low, high) = self.bounds();
        low.is_none_or(|low| interval.low > low) && high.is_none_or(|high| interval.high < high)
    }

    /// Whether the whole interval lies on the other side.
    pub fn opposes(&self, interval: Interval) -> bool {
        let (low, high) = self.bounds();
        low.is_some_and(|low| interval.high < low) || high.is_some_and(|high| interval.low > high)
    }
}
