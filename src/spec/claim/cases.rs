//! The arms that a claim compares: its patterns applied to the arms of a suite.
//!
//! An axis that neither pattern names is free: arms are compared at equal points of it. A case is one arm, or
//! two arms that agree on every free axis.

use super::{ArmPattern, Claim};

/// The points of an arm, by axis.
pub type Points = [(String, String)];

/// One comparison of a claim; arms are indices into the list of arms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// What distinguishes it from the claim's other cases: `robot=atlas`; empty if there is only one.
    pub label: String,
    /// The arm `a`.
    pub a: usize,
    /// The arm `b`, when the claim compares two.
    pub b: Option<usize>,
}

/// The arms that a pattern matches, in their order.
pub fn matching(pattern: &ArmPattern, arms: &[&Points]) -> Vec<usize> {
    (0..arms.len()).filter(|arm| pattern.matches(|axis| point(arms[*arm], axis))).collect()
}

/// The cases of a claim, in the order of the arms.
pub fn cases(claim: &Claim, arms: &[&Points]) -> Vec<Case> {
    let Some(a) = claim.sides.get("a") else { return Vec::new() };
    let mut cases: Vec<Case> = Vec::new();
    for first in matching(a, arms) {
        match claim.sides.get("b") {
            None => cases.push(Case { label: String::new(), a: first, b: None }),
            Some(b) => {
                let agrees = |axis: &str| point(arms[first], axis);
                let seconds = matching(b, arms).into_iter().filter(|second| {
                    let free = arms[*second].iter().filter(|(axis, _)| !a.fixes(axis) && !b.fixes(axis));
                    free.into_iter().all(|(axis, own)| agrees(axis) == Some(own))
                });
                cases.extend(seconds.map(|second| Case { label: String::new(), a: first, b: Some(second) }));
            }
        }
    }
    label(claim, arms, &mut cases);
    cases
}

/// Arms that match a pattern but have no counterpart, so they are in no case.
pub fn unpaired(claim: &Claim, arms: &[&Points], cases: &[Case]) -> Vec<usize> {
    let in_case = |arm: usize| cases.iter().any(|case| case.a == arm || case.b == Some(arm));
    claim.sides.values().flat_map(|pattern| matching(pattern, arms)).filter(|arm| !in_case(*arm)).collect()
}

/// A point of the claim's `over` axis, or a counted case, with its cases.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alternative {
    /// The point; empty for a claim without an `over` axis.
    pub point: String,
    /// Indices of the cases.
    pub cases: Vec<usize>,
}

/// The alternatives of a claim in the order of their first cases: one per point of the `over` axis, one per
/// counted case, or all cases together.
pub fn alternatives(claim: &Claim, arms: &[&Points], cases: &[Case]) -> Vec<Alternative> {
    let mut found: Vec<Alternative> = Vec::new();
    for (place, case) in cases.iter().enumerate() {
        let point = alternative(claim, arms, case).unwrap_or_default();
        match found.iter_mut().find(|other| other.point == point) {
            Some(other) => other.cases.push(place),
            None => found.push(Alternative { point, cases: vec![place] }),
        }
    }
    found
}

/// The point of the `over` axis that a case belongs to: that of the arm whose pattern leaves the axis open.
/// For a claim that counts cases, the case itself.
pub fn alternative(claim: &Claim, arms: &[&Points], case: &Case) -> Option<String> {
    let over = claim.over.as_ref()?;
    if over.count().is_some() {
        return Some(case.label.clone());
    }
    let axis = over.axis()?;
    let open = |side: &str| claim.sides.get(side).is_some_and(|pattern| !pattern.fixes(axis));
    let of = |arm: usize| point(arms[arm], axis).map(str::to_owned);
    match case.b {
        Some(b) if !open("a") => of(b),
        _ => of(case.a),
    }
}

/// The arm that a claim compares this arm's runs with: at the twin's points, otherwise at this arm's.
pub fn twin(pattern: &ArmPattern, arms: &[&Points], arm: usize) -> Option<usize> {
    counterparts(pattern, arms, arm).into_iter().find(|other| *other != arm)
}

/// All arms that have the twin's points and otherwise this arm's; may include this arm.
pub fn counterparts(pattern: &ArmPattern, arms: &[&Points], arm: usize) -> Vec<usize> {
    let is_named = |axis: &str| pattern.terms.iter().any(|term| term.axis == axis);
    let agrees = |other: &Points| {
        let own = arms[arm].iter().filter(|(axis, _)| !is_named(axis));
        own.into_iter().all(|(axis, own)| point(other, axis) == Some(own))
    };
    matching(pattern, arms).into_iter().filter(|other| agrees(arms[*other])).collect()
}

/// Labels each case with the points in which the cases differ.
fn label(claim: &Claim, arms: &[&Points], cases: &mut [Case]) {
    let points = |case: &Case| -> Vec<(String, String)> {
        let loose = |side: &str, arm: usize| {
            let pattern = claim.sides.get(side);
            arms[arm].iter().filter(move |(axis, _)| pattern.is_some_and(|pattern| !pattern.fixes(axis)))
        };
        let mut all: Vec<(String, String)> = loose("a", case.a).cloned().collect();
        let others = case.b.into_iter().flat_map(|b| loose("b", b));
        all.extend(
            others
                .filter(|(axis, _)| point(arms[case.a], axis).is_none() || claim.sides["a"].fixes(axis))
                .cloned(),
        );
        all
    };
    let all: Vec<_> = cases.iter().map(points).collect();
    for (case, own) in cases.iter_mut().zip(&all) {
        let varies = |(axis, value): &&(String, String)| {
            all.iter().any(|other| point(other, axis) != Some(value.as_str()))
        };
        let words: Vec<String> =
            own.iter().filter(varies).map(|(axis, point)| format!("{axis}={point}")).collect();
        case.label = words.join(",");
    }
}

fn point<'a>(arm: &'a Points, axis: &str) -> Option<&'a str> {
    arm.iter().find(|(own, _)| own == axis).map(|(_, point)| point.as_str())
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::*;

    fn arms() -> Vec<Vec<(String, String)>> {
        let mut arms = Vec::new();
        for robot in ["tocabi", "atlas"] {
            for (control, std) in [("torque", "10 %"), ("torque", "5 %"), ("position", "1 %")] {
                arms.push(
                    [("robot", robot), ("control", control), ("std", std)]
                        .map(|(a, p)| (a.into(), p.into()))
                        .to_vec(),
                );
            }
        }
        arms
    }

    /// Label and arms of every case.
    type Found = Vec<(String, usize, Option<usize>)>;

    fn found(a: &str, b: Option<&str>) -> (Found, Vec<usize>) {
        let (claim, arms) = (sample(a, b), arms());
        let arms: Vec<&Points> = arms.iter().map(Vec::as_slice).collect();
        let cases = cases(&claim, &arms);
        let unpaired = unpaired(&claim, &arms, &cases);
        (cases.into_iter().map(|case| (case.label, case.a, case.b)).collect(), unpaired)
    }

    #[test]
    fn arms_are_compared_at_equal_points_of_the_free_axes() {
        let (cases, unpaired) = found("control=torque,std=10 %", Some("control=position,std=1 %"));
        assert_eq!(cases, [("robot=tocabi".into(), 0, Some(2)), ("robot=atlas".into(), 3, Some(5))]);
        assert!(unpaired.is_empty());
    }

    #[test]
    fn an_axis_that_one_side_fixes_may_vary_on_the_other() {
        let (cases, _) = found("robot=atlas,control=torque", Some("robot=atlas,std=1 %"));
        assert_eq!(cases, [("std=10 %".into(), 3, Some(5)), ("std=5 %".into(), 4, Some(5))]);
    }

    #[test]
    fn an_arm_without_a_counterpart_is_told() {
        let (cases, unpaired) = found("control=torque", Some("robot=atlas,control=position"));
        assert!(cases.is_empty());
        assert_eq!(unpaired, [0, 1, 3, 4, 5]);
    }

    #[test]
    fn a_twin_differs_in_the_named_points_alone() {
        let arms = arms();
        let arms: Vec<&Points> = arms.iter().map(Vec::as_slice).collect();
        let pattern = &sample("robot=tocabi,control=torque", None).sides["a"];
        assert_eq!([3, 4, 5, 0].map(|arm| twin(pattern, &arms, arm)), [Some(0), Some(1), None, None]);
    }

    #[test]
    fn one_arm_is_one_case_without_a_label() {
        assert_eq!(found("robot=atlas,std=1 %", None).0, [(String::new(), 5, None)]);
    }
}
