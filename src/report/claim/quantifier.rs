//! Combines the comparisons of a claim into its verdict, and derives the level of each comparison.
//!
//! "At some of S alternatives all comparisons hold" is a union of intersections. An alternative is
//! established by the intersection of its comparisons (each at the alternative's level: the
//! intersection-union test, Berger 1982) and refuted by any one of them (at that level divided by their
//! number: Bonferroni). "Some alternative" is established by any one of them (at alpha / S:
//! union-intersection, Roy 1953), and refuted when every one is (each at alpha: intersection-union again).
//! `each` is the case of a single alternative, `none` the opposite of `some`.

use super::{Alternative, Case, Ruling};
use crate::spec::claim::Over;

/// A comparison with its p values.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// The comparison.
    pub case: Case,
    /// The p value in favour of the expectation; `None` when the sample gives none.
    pub p_for: Option<f64>,
    /// The p value against it.
    pub p_against: Option<f64>,
}

/// The comparisons of a claim by alternative.
#[derive(Clone, Debug)]
pub struct Quantifier {
    alternatives: Vec<(String, Vec<usize>)>,
    /// How many alternatives must hold.
    needed: usize,
    is_listed: bool,
    is_negated: bool,
}

impl Quantifier {
    /// Groups comparisons, given the alternative of each.
    pub fn new<'a>(over: Option<&Over>, alternatives: impl Iterator<Item = &'a str>) -> Self {
        let mut sorted: Vec<(String, Vec<usize>)> = Vec::new();
        for (place, own) in alternatives.enumerate() {
            match sorted.iter_mut().find(|(known, _)| known == own) {
                Some((_, places)) => places.push(place),
                None => sorted.push((own.to_owned(), vec![place])),
            }
        }
        // "At most n hold" is the opposite of "at least n + 1 hold".
        let needed = match over {
            Some(Over::AtLeast(count)) => *count,
            Some(Over::AtMost(count)) => count + 1,
            _ => 1,
        };
        let is_listed = over.is_some_and(|over| over.axis().is_some() || over.count().is_some());
        let is_negated = matches!(over, Some(Over::None(_) | Over::AtMost(_)));
        Self { alternatives: sorted, needed, is_listed, is_negated }
    }

    /// How many alternatives must be refuted so that too few remain.
    fn refuting(&self) -> usize {
        (self.alternatives.len() + 1).saturating_sub(self.needed)
    }

    /// The divisors of alpha for establishing and for refuting the comparison at this index (partial
    /// conjunctions, Benjamini and Heller 2008).
    pub fn divisors(&self, place: usize) -> [f64; 2] {
        let own = self.alternatives.iter().find(|(_, places)| places.contains(&place));
        let comparisons = own.map_or(1, |(_, places)| places.len());
        [self.refuting().max(1) as f64, (self.needed * comparisons) as f64]
    }

    /// The verdict on the claim.
    pub fn ruling(&self, cases: &[Weighed]) -> Ruling {
        let rulings: Vec<Ruling> =
            self.alternatives.iter().map(|(_, places)| together(cases, places)).collect();
        let count = |wanted: Ruling| rulings.iter().filter(|ruling| **ruling == wanted).count();
        let enough = match rulings.is_empty() {
            true => Ruling::NotEstablished,
            false if count(Ruling::Pass) >= self.needed => Ruling::Pass,
            false if count(Ruling::Fail) >= self.refuting() => Ruling::Fail,
            false => Ruling::NotEstablished,
        };
        match enough {
            Ruling::Pass if self.is_negated => Ruling::Fail,
            Ruling::Fail if self.is_negated => Ruling::Pass,
            ruling => ruling,
        }
    }

    /// The verdict at each alternative; empty for a claim with a single one.
    pub fn alternatives(&self, cases: &[Weighed]) -> Vec<Alternative> {
        let sorted = self.alternatives.iter().filter(|_| self.is_listed);
        sorted
            .map(|(point, places)| Alternative { point: point.clone(), verdict: together(cases, places) })
            .collect()
    }

    /// The p value that enters Holm's correction: the smaller of those for and against the claim. A
    /// comparison without a p value counts as p = 1; `None` when no comparison has one.
    pub fn p(&self, cases: &[Weighed]) -> Option<f64> {
        if cases.iter().all(|weighed| weighed.p_for.is_none()) {
            return None;
        }
        let holds = |places: &Vec<usize>| {
            places.iter().map(|place| cases[*place].p_for.unwrap_or(1.0)).fold(0.0, f64::max)
        };
        let opposed = |places: &Vec<usize>| {
            let least = places.iter().map(|place| cases[*place].p_against.unwrap_or(1.0)).fold(1.0, f64::min);
            (least * places.len() as f64).min(1.0)
        };
        // The p value for `count` of these nulls being false: Bonferroni over those that may be true.
        let conjunction = |of: &dyn Fn(&Vec<usize>) -> f64, count: usize| {
            let mut all: Vec<f64> = self.alternatives.iter().map(|(_, places)| of(places)).collect();
            all.sort_by(f64::total_cmp);
            let largest = count.checked_sub(1).and_then(|at| all.get(at)).copied().unwrap_or(1.0);
            (largest * (all.len() + 1).saturating_sub(count) as f64).min(1.0)
        };
        Some(conjunction(&holds, self.needed).min(conjunction(&opposed, self.refuting())))
    }
}

/// Comparisons that must all hold: PASS when all pass, FAIL when any fails.
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

    /// A comparison with this p value, for or against the expectation.
    fn weighed(verdict: Ruling, p: f64, expected: bool) -> Weighed {
        let [p_for, p_against] = if expected { [p, 1.0] } else { [1.0, p] }.map(Some);
        Weighed { case: Case { verdict, p: Some(p), ..Case::default() }, p_for, p_against }
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
                other => other,
            };
            assert_eq!(ruling(&none(), verdicts), opposite, "{verdicts:?}");
        }
        assert_eq!(
            Quantifier::new(Some(&none()), [].into_iter()).ruling(&[]),
            NotEstablished,
            "nothing was measured"
        );
    }

    #[test]
    fn p_values_are_the_largest_of_an_intersection_and_the_smallest_of_a_union_times_its_size() {
        let places = || ["k8", "k8", "k4", "k4"].into_iter();
        let quantifier = Quantifier::new(Some(&some()), places());
        // In favour: k8 has 0.02 (the larger), k4 cannot hold, and with two alternatives that gives 0.04. k8
        // cannot be refuted.
        let cases = [(0.01, true), (0.02, true), (0.001, false), (0.3, true)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.04).abs() < 1e-12);
        // Against: k8 has 2 x 0.004, k4 2 x 0.01, and the larger counts. Nothing is in favour.
        let cases = [(0.004, false), (0.2, true), (0.01, false), (0.05, false)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.02).abs() < 1e-12);
        let each = Quantifier::new(Some(&Over::Each), ["", ""].into_iter());
        let both = [weighed(Pass, 0.01, true), weighed(Pass, 0.03, true)];
        assert_eq!(each.p(&both), Some(0.03), "all must hold");
        let one = [weighed(Pass, 0.01, true), weighed(Fail, 0.02, false)];
        assert_eq!(each.p(&one), Some(0.04), "one of two is enough against it");
        let lacking = || Weighed { case: Case::default(), p_for: None, p_against: None };
        assert_eq!(each.p(&[both[0].clone(), lacking()]), Some(1.0), "one shows nothing");
        assert_eq!(each.p(&[lacking(), lacking()]), None);
    }

    #[test]
    fn comparisons_are_counted() {
        let labels = || ["a", "b", "c", "d"].into_iter();
        let judged = |over: &Over, verdicts: [Ruling; 4]| {
            let cases = verdicts.map(|verdict| weighed(verdict, 0.01, verdict == Pass));
            Quantifier::new(Some(over), labels()).ruling(&cases)
        };
        let (least, most) = (Over::AtLeast(3), Over::AtMost(2));
        for (verdicts, expected, opposite) in [
            ([Pass, Pass, NotEstablished, Pass], Pass, Fail),
            ([Pass, Fail, NotEstablished, Fail], Fail, Pass),
            ([Pass, Pass, NotEstablished, Fail], NotEstablished, NotEstablished),
        ] {
            assert_eq!(
                (judged(&least, verdicts), judged(&most, verdicts)),
                (expected, opposite),
                "{verdicts:?}"
            );
        }
        // Three of four: each at alpha / 2. The opposite needs two of four, each at alpha / 3.
        let quantifier = Quantifier::new(Some(&least), labels());
        assert_eq!(quantifier.divisors(0), [2.0, 3.0]);
        let cases = [(0.01, true), (0.03, true), (0.02, true), (0.4, false)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.06).abs() < 1e-12, "twice the third smallest");
        let cases = [(0.01, false), (0.03, false), (0.2, true), (0.4, true)];
        let cases = cases.map(|(p, side)| weighed(NotEstablished, p, side));
        assert!((quantifier.p(&cases).expect("a p") - 0.09).abs() < 1e-12, "thrice the second smallest");
    }
}
