//! Where a claim expects the estimate, and whether an interval lies there.

use super::Interval;
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Claim, Operand, Relation};

/// Where a claim expects the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Where equality lies: 0, the claim's number, or one half.
    centre: f64,
    relation: Relation,
    /// Distance of the boundary from the centre: the margin, or the tolerance of `==`.
    distance: f64,
}

impl Region {
    /// What a claim expects of the estimate of its test.
    pub fn of(claim: &Claim, statistic: &StatisticKind) -> Self {
        let centre = match (&claim.expect.right, statistic.method) {
            (Operand::Number(number), _) => number.si,
            (_, Method::ProbabilityOfImprovement) => 0.5,
            _ => 0.0,
        };
        let distance = claim.expect.within.as_ref().or(claim.margin.as_ref()).map_or(0.0, |quantity| quantity.si);
        Self { centre, relation: claim.expect.relation, distance }
    }

    /// Whether a p value of this method speaks of the boundary: it must have one, and where it does not lie at equality the
    /// method must be able to test another place.
    pub fn is_spoken_of_by(&self, method: Method) -> bool {
        let only_equality = matches!(method, Method::Mcnemar | Method::Newcombe);
        self.relation != Relation::Equal && (self.distance == 0.0 || !only_equality)
    }

    /// The boundary; of a range the middle.
    pub fn boundary(&self) -> f64 {
        match self.bounds() {
            (Some(bound), None) | (None, Some(bound)) => bound,
            _ => self.centre,
        }
    }

    /// The lower boundary of what is expected, if it has one, and the upper.
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

    /// Whether the whole interval lies where it is expected; a boundary that it touches is not crossed.
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
