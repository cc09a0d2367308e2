//! What the comparisons of a claim come to together, and at which level each is judged.
//!
//! The claim that at some of S alternatives all of their comparisons hold is a union of intersections. An alternative is
//! established by the intersection of its comparisons (each at the alternative's level: the intersection-union test, Berger
//! 1982) and refuted by any one of them (at that level divided by their number: Bonferroni). Some alternative is established
//! by any one of them (at alpha / S: union-intersection, Roy 1953), and refuted when every one is (each at alpha: again
//! intersection-union). `each` is the same with one alternative, `none` the opposite.

use super::{Alternative, Case, Ruling};
use crate::spec::claim::Over;

/// A comparison, and on which side of the boundary its estimate lies; `None` when it has none.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// The comparison.
    pub case: Case,
    /// Whether the estimate lies where it is expected.
    pub expected: Option<bool>,
}

/// The comparisons of a claim by alternative.
#[derive(Clone, Debug)]
pub struct Quantifier {
    alternatives: Vec<(String, Vec<usize>)>,
    is_over_an_axis: bool,
    is_negated: bool,
}

impl Quantifier {
    /// Sorts comparisons, given the alternative of each.
    pub fn new<'a>(over: Option<&Over>, alternatives: impl Iterator<Item = &'a str>) -> Self {
        let mut sorted: Vec<(String, Vec<usize>)> = Vec::new();
        for (place, own) in alternatives.enumerate() {
            match sorted.iter_mut().find(|(known, _)| known == own) {
                Some((_, places)) => places.push(place),
                None => sorted.push((own.to_owned(), vec![place])),
            }
        }
        let is_over_an_axis = over.is_some_and(|over| over.axis().is_some());
        Self { alternatives: sorted, is_over_an_axis, is_negated: matches!(over, Some(Over::None(_))) }
    }

    /// By how much alpha is divided where the comparison at a place is to hold, and where it is to be opposed.
    pub fn divisors(&self, place: usize) -> [f64; 2] {
        let own = self.alternatives.iter().find(|(_, places)| places.contains(&place));
        [self.alternatives.len() as f64, own.map_or(1, |(_, places)| places.len()) as f64]
    }

    /// What becomes of the claim.
    pub fn ruling(&self, cases: &[Weighed]) -> Ruling {
        let rulings: Vec<Ruling> = self.alternatives.iter().map(|(_, places)| together(cases, places)).collect();
        let any = |wanted: Ruling| rulings.contains(&wanted);
        let some = match (any(Ruling::Pass), any(Ruling::NotEstablished), rulings.is_empty()) {
            (true, ..) => Ruling::Pass,
            (false, false, false) => Ruling::Fail,
            _ => Ruling::NotEstablished,
        };
        match some {
            Ruling::Pass if self.is_negated => Ruling::Fail,
            Ruling::Fail if self.is_negated => Ruling::Pass,
            ruling => ruling,
        }
    }

    /// What became of each alternative; none for a claim that is over no axis.
    pub fn alternatives(&self, cases: &[Weighed]) -> Vec<Alternative> {
        let sorted = self.alternatives.iter().filter(|_| self.is_over_an_axis);
        sorted.map(|(point, places)| Alternative { point: point.clone(), verdict: together(cases, places) }).collect()
    }

    /// The p value with which the claim enters Holm's correction: the smaller of those for and against it. Without a p value
    /// in every comparison there is none.
    pub fn p(&self, cases: &[Weighed]) -> Option<f64> {
        let all: Vec<f64> = cases.iter().map(|weighed| weighed.case.p).collect::<Option<_>>()?;
        let on_side = |place: usize, side: bool| if cases[place].expected == Some(side) { all[place] } else { 1.0 };
        let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
        let smallest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(1.0, f64::min);
        let count = self.alternatives.len() as f64;
        let holds = |places: &Vec<usize>| largest(&mut places.iter().map(|place| on_side(*place, true)));
        let opposed = |places: &Vec<usize>| {
            let least = smallest(&mut places.iter().map(|place| on_side(*place, false)));
            (least * places.len() as f64).min(1.0)
        };
        let some = count * smallest(&mut self.alternatives.iter().map(|(_, places)| holds(places)));
        let none = largest(&mut self.alternatives.iter().map(|(_, places)| opposed(places)));
        (!cases.is_empty()).then(|| some.min(none).min(1.0))
    }
}

/// Comparisons that must all hold: they do when all pass, and do not when one fails.
fn together(cases: &[Weighed], places: &[usize]) -> Ruling {
    let any = |ruling: Ruling| places.iter().any(|place| cases[*place].case.verdict == ruling);
    match (any(Ruling::Fail), any(Ruling::NotEstablished), places.is_empty()) {
        (true, ..) => Ruling::Fail,
        (false, false, false) => Ruling::Pass,
        _ => Ruling::NotEstablished,
    }
}

#[cfg(test)]
mod tests {
    use Ruling::{Fail, NotEstablished, Pass};

    use super::*;

    /// A comparison with this p value, on the expected side or the other.
    fn weighed(verdict: Ruling, p: f64, expected: bool) -> Weighed {
        Weighed { case: Case { verdict, p: Some(p), ..Case::default() }, expected: Some(expected) }
    }

    fn some() -> Over {
        Over::Some("setting".into())
    }

    fn none() -> Over {
        Over::None("setting".into())
    }

    #[test]
    fn levels_are_shared_by_alternatives_to_hold_and_by_comparisons_to_be_opposed() {
        let quantifier = Quantifier::new(Some(&none()), ["k8", "k8", "k4", "k4", "k4"].into_iter());
        assert_eq!([0, 2].map(|place| quantifier.divisors(place)), [[2.0, 2.0], [2.0, 3.0]]);
        let each = Quantifier::new(Some(&Over::Each), ["", "", ""].into_iter());
        assert_eq!(each.divisors(1), [1.0, 3.0]);
    }

    #[test]
    fn some_point_serves_when_all_its_comparisons_hold_and_none_does_when_each_fails_in_one() {
        let places = || ["k8", "k8", "k4", "k4"].into_iter();
        let ruling = |over: &Over, verdicts: [Ruling; 4]| {
            let cases = verdicts.map(|verdict| weighed(verdict, 0.01, verdict == Pass));
            Quantifier::new(Some(over), places()).ruling(&cases)
        };
        for (verdicts, expected) in [
            ([Fail, Pass, Pass, Pass], Pass),
            ([NotEstablished, NotEstablished, Pass, Pass], Pass),
            ([Fail, Pass, Pass, Fail], Fail),
            ([Fail, Fail, Pass, NotEstablished], NotEstablished),
            ([Pass, NotEstablished, NotEstablished, Pass], NotEstablished),
        ] {
            assert_eq!(ruling(&some(), verdicts), expected, "{verdicts:?}");
            let opposite = match expected {
                Pass => Fail,
                Fail => Pass,
                NotEstablished => NotEstablished,
            };
            assert_eq!(ruling(&none(), verdicts), opposite, "{verdicts:?}");
        }
        assert_eq!(Quantifier::new(Some(&none()), [].into_iter()).ruling(&[]), NotEstablished, "nothing was measured");
    }

    #[test]
    fn p_values_are_the_largest_of_an_intersection_and_the_smallest_of_a_union_times_its_size() {
        let places = || ["k8", "k8", "k4", "k4"].into_iter();
        let quantifier = Quantifier::new(Some(&some()), places());
        // For: k8 has 0.02 (the larger), k4 cannot hold; two alternatives: 0.04. Against: k8 cannot be opposed.
        let cases = [(0.01, true), (0.02, true), (0.001, false), (0.3, true)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.04).abs() < 1e-12);
        // Against: k8 has 2 x 0.004, k4 2 x 0.01, and the larger counts; for it there is nothing.
        let cases = [(0.004, false), (0.2, true), (0.01, false), (0.05, false)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.02).abs() < 1e-12);
        let each = Quantifier::new(Some(&Over::Each), ["", ""].into_iter());
        let both = [weighed(Pass, 0.01, true), weighed(Pass, 0.03, true)];
        assert_eq!(each.p(&both), Some(0.03), "all must hold");
        let one = [weighed(Pass, 0.01, true), weighed(Fail, 0.02, false)];
        assert_eq!(each.p(&one), Some(0.04), "one of two is enough against it");
        let lacking = Weighed { case: Case::default(), expected: Some(true) };
        assert_eq!(each.p(&[both[0].clone(), lacking]), None);
    }
}
