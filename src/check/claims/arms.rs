//! E0803 and E0806: the arms that a claim names exist, and their number suits the claim.

use super::{Scope, at, name};
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::claim::cases::{counterparts, matching};
use crate::spec::claim::{
    ArmPattern, Case, Claim, Over, Points, Term, alternatives, cases, is_meant, keys, unpaired,
};
use crate::spec::suggest::{listed, nearest};

/// The cases of a claim; `None` after a mistake.
pub fn cases_of(claim: &Claim, scope: &Scope, sink: &mut Sink) -> Option<Vec<Case>> {
    let points = scope.points();
    let mut known = true;
    for (side, pattern) in &claim.sides {
        let path = claim.key_of_side(side);
        known &= exists(claim, &path, pattern, scope, sink);
    }
    known &= axis_exists(claim, scope, sink);
    let pattern = claim.baseline.as_ref().and_then(|baseline| baseline.twin.as_ref());
    known &= pattern.is_none_or(|pattern| exists(claim, keys::Claim::twin.name, pattern, scope, sink));
    let cases = known.then(|| cases(claim, &points))?;
    if let Some(pattern) = pattern {
        have_twins(claim, pattern, scope, &cases, sink)?;
    }
    match trouble(claim, scope, &points, &cases) {
        Some((key, diagnostic, remark)) => {
            sink.emit(at(claim, key, diagnostic, &remark));
            None
        }
        None => Some(cases),
    }
}

/// E0803, E0805 and E0806: every arm of the cases has exactly one other arm that differs only in the twin's
/// points, with the same number of seeds.
fn have_twins(
    claim: &Claim,
    pattern: &ArmPattern,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) -> Option<()> {
    let points = scope.points();
    let arms = cases.iter().flat_map(|case| [Some(case.a), case.b]).flatten();
    let trouble = arms.into_iter().find_map(|arm| {
        let own = name(scope.arms[arm].points);
        match counterparts(pattern, &points, arm).as_slice() {
            [other] if *other != arm => fewer_seeds(scope, arm, *other),
            [] | [_] => {
                let message = format!("the arm `{own}` has no twin at `{}`", pattern.written());
                let help = "name points of another arm, which has the same points on every other axis";
                let error = Diagnostic::error("E0803", message).help(help);
                Some((error, "no other arm has these points and else the same".to_owned()))
            }
            several => {
                let message = format!("the arm `{own}` has {} twins, not one", several.len());
                let names: Vec<String> = several.iter().map(|arm| name(scope.arms[*arm].points)).collect();
                let remark = format!("matches {}", listed(names.iter().map(String::as_str)));
                let help =
                    "name one point of each axis, without `|` and `*`: a run is compared with that of one \
                     other arm";
                Some((Diagnostic::error("E0806", message).help(help), remark))
            }
        }
    });
    let Some((error, remark)) = trouble else { return Some(()) };
    sink.emit(at(claim, keys::Claim::twin.name, error, &remark));
    None
}

/// E0805: the twin has a run for each seed of the arm.
fn fewer_seeds(scope: &Scope, arm: usize, twin: usize) -> Option<(Diagnostic, String)> {
    let [own, other] = [arm, twin].map(|arm| &scope.arms[arm]);
    if other.runs >= own.runs {
        return None;
    }
    let message =
        format!("too few seeds: the twin of `{}` has {}, not {}", name(own.points), other.runs, own.runs);
    let help = "give the twin all seeds of the arm, or leave out the same seeds of both: runs of equal seeds \
        are compared";
    Some((Diagnostic::error("E0805", message).help(help), format!("this is `{}`", name(other.points))))
}

/// The place of one point of a term, given the place of all its points.
fn place_of(term: &Term, point: &str, all: Span) -> Span {
    match term.point.find(point) {
        // Without escapes, text and source have the same length.
        Some(at) if all.end - all.start == term.point.len() => {
            Span { start: all.start + at, end: all.start + at + point.len(), ..all }
        }
        _ => all,
    }
}

/// Whether an alternative of a term matches any of these points.
fn names_one(written: &str, known: &[&str]) -> bool {
    known.iter().any(|point| is_meant(written, point))
}

/// E0803: every axis and point that a claim names exists, regardless of which arms do.
pub fn names_are_known(claim: &Claim, scope: &Scope, sink: &mut Sink) {
    for (side, pattern) in &claim.sides {
        let path = claim.key_of_side(side);
        terms_exist(claim, &path, pattern, scope, sink);
    }
    axis_exists(claim, scope, sink);
    if let Some(pattern) = claim.baseline.as_ref().and_then(|baseline| baseline.twin.as_ref()) {
        terms_exist(claim, keys::Claim::twin.name, pattern, scope, sink);
    }
}

/// Every axis and point of a pattern exists, and some arm matches them all.
fn exists(claim: &Claim, path: &str, pattern: &ArmPattern, scope: &Scope, sink: &mut Sink) -> bool {
    if !terms_exist(claim, path, pattern, scope, sink) {
        return false;
    }
    if matching(pattern, &scope.points()).is_empty() {
        let error =
            Diagnostic::error("E0803", "the claim names an unknown arm: no arm is at all of these points");
        let error = at(claim, path, error, "left out of the sweep");
        sink.emit(error.help(
            "the combination was excluded, or is not included: name another, or take it into the sweep",
        ));
        return false;
    }
    true
}

/// Every axis and point of a pattern exists.
fn terms_exist(claim: &Claim, path: &str, pattern: &ArmPattern, scope: &Scope, sink: &mut Sink) -> bool {
    let mut sound = true;
    for (index, term) in pattern.terms.iter().enumerate() {
        let mark = claim.marks.get(&format!("{path}.{index}"));
        let axis = scope.axes.iter().find(|(name, _)| *name == term.axis);
        let (message, word, valid, span) = match axis {
            None => {
                let names: Vec<&str> = scope.axes.iter().map(|(name, _)| *name).collect();
                (format!("no axis `{}`", term.axis), term.axis.as_str(), names, mark.map(|mark| mark.key))
            }
            Some((_, known)) => match term.points().into_iter().find(|point| !names_one(point, known)) {
                None => continue,
                Some(point) => {
                    let message = format!("no point `{point}` on the axis `{}`", term.axis);
                    (message, point, known.clone(), mark.map(|mark| place_of(term, point, mark.value)))
                }
            },
        };
        let mut error =
            Diagnostic::error("E0803", format!("the claim names an unknown arm: the suite has {message}"));
        if let Some(span) = span {
            error = error.at(span, "unknown");
        }
        let near = nearest(word, valid.iter().copied());
        error = match (near, span) {
            (Some(near), Some(span)) => error.help(format!("did you mean `{near}`?")).fix(span, near),
            _ if axis.is_none() => error.help(format!("the axes are {}", listed(valid))),
            _ => error.help(format!("the points of `{}` are {}", term.axis, listed(valid))),
        };
        sink.emit(error);
        sound = false;
    }
    sound
}

/// The `over` axis of a claim is one of the suite's.
fn axis_exists(claim: &Claim, scope: &Scope, sink: &mut Sink) -> bool {
    let Some((key, axis)) = claim.over.as_ref().and_then(Over::named) else { return true };
    let axes = || scope.axes.iter().map(|(name, _)| *name);
    if axes().any(|known| known == axis) {
        return true;
    }
    let error =
        Diagnostic::error("E0803", format!("the claim is over an axis `{axis}`, and the suite has none"));
    let error = at(claim, &key, error, "unknown");
    let span = claim.marks.get(&key).map(|mark| mark.value);
    sink.emit(match (nearest(axis, axes()), span) {
        (Some(near), Some(span)) => {
            error.help(format!("did you mean `{near}`?")).fix(span, format!("\"{near}\""))
        }
        _ => error.help(format!("the axes are {}", listed(axes()))),
    });
    false
}

/// What is wrong with the cases of a claim: the key to point at, the error and the label.
fn trouble(
    claim: &Claim,
    scope: &Scope,
    points: &[&Points],
    cases: &[Case],
) -> Option<(&'static str, Diagnostic, String)> {
    let key = claim.key_of_sides();
    let first = |arms: &[usize]| arms.first().map(|arm| name(scope.arms[*arm].points)).unwrap_or_default();
    let alone = unpaired(claim, points, cases);
    if !alone.is_empty() {
        let message = format!("the arm `{}` has no counterpart in this claim", first(&alone));
        let error = Diagnostic::error("E0806", message);
        let help = "arms are compared at equal points of every axis that neither side names: name the axes \
            on which they differ";
        return Some((key, error.help(help), "these arms differ on an axis that is not named".to_owned()));
    }
    let several =
        || Diagnostic::error("E0806", format!("the claim names {} comparisons, not one", cases.len()));
    if let Some(same) = cases.iter().find(|case| Some(case.a) == case.b) {
        let all = cases.iter().all(|case| Some(case.a) == case.b);
        let (message, help) = match all {
            true => ("the claim compares arms with themselves".to_owned(), "name two arms that differ"),
            false => (
                format!("the claim compares the arm `{}` with itself", first(&[same.a])),
                "name in one side only points that are not in the other",
            ),
        };
        return Some((
            key,
            Diagnostic::error("E0806", message).help(help),
            "both sides are the same".to_owned(),
        ));
    }
    match &claim.over {
        None if cases.len() > 1 => {
            let labels: Vec<&str> = cases.iter().map(|case| case.label.as_str()).collect();
            let shown = listed(labels.iter().copied().take(4));
            let help = format!(
                "name one of {shown}{}, or say what is claimed of them: `over = \"each\"` or `over = \
                 \"mean\"`",
                if labels.len() > 4 { " ..." } else { "" }
            );
            Some((key, several().help(help), format!("matches {}", cases.len())))
        }
        Some(over) if over.axis().is_some() && alternatives(claim, points, cases).len() < 2 => {
            let axis = over.axis().unwrap_or_default();
            let message = format!("the claim is over the axis `{axis}` and names one point of it");
            let help = format!("name several of its points, for example `{axis}=*`, or remove `over`");
            Some((
                keys::Claim::over.name,
                Diagnostic::error("E0806", message).help(help),
                "nothing to choose from".to_owned(),
            ))
        }
        Some(over)
            if over.count().is_some_and(|count| {
                !(1..=most_usable(over, cases.len())).contains(&usable(over, count))
            }) =>
        {
            let count = over.count().unwrap_or_default();
            let message = format!(
                "the claim names {} comparisons, and {} of them is not a choice",
                cases.len(),
                over.in_words()
            );
            let help = match over {
                Over::AtLeast(_) if count == cases.len() => "write `over = \"each\"`".to_owned(),
                _ => format!("write a number below {}", cases.len()),
            };
            Some((
                keys::Claim::over.name,
                Diagnostic::error("E0806", message).help(help),
                "always or never so".to_owned(),
            ))
        }
        Some(Over::Trend(axis))
            if cases.len() < FEWEST_OF_A_TREND || repeats(cases) || !differ_in(axis, points, cases) =>
        {
            let message = format!(
                "a trend over `{axis}` takes one comparison at each of its points, and three or more"
            );
            let help = format!(
                "name the points of `{axis}` and one point of every other axis, for example `arm = \
                 \"{axis}=*\"`"
            );
            Some((key, Diagnostic::error("E0806", message).help(help), format!("matches {}", cases.len())))
        }
        Some(Over::Mean) if repeats(cases) => {
            let help = "the mean over arms takes each arm once: name the axis on which one side varies, or \
                write `over = \"each\"`";
            Some((
                keys::Claim::over.name,
                several().help(help),
                "one arm is in several comparisons".to_owned(),
            ))
        }
        _ => None,
    }
}

/// Minimum number of points of a trend.
const FEWEST_OF_A_TREND: usize = 3;

/// Whether every case is at a different point of an axis.
fn differ_in(axis: &str, points: &[&Points], cases: &[Case]) -> bool {
    let of =
        |case: &Case| points[case.a].iter().find(|(own, _)| own == axis).map(|(_, point)| point.as_str());
    let mut all: Vec<Option<&str>> = cases.iter().map(of).collect();
    all.sort_unstable();
    all.dedup();
    all.len() == cases.len()
}

/// A count of comparisons, shifted to the range in which it is a real choice: 1 to all but one. `AtMost(0)`
/// is one.
fn usable(over: &Over, count: usize) -> usize {
    if matches!(over, Over::AtMost(_)) { count + 1 } else { count }
}

/// The largest such count: "all hold" is `each`, but "at most all but one" is a choice.
fn most_usable(over: &Over, cases: usize) -> usize {
    if matches!(over, Over::AtMost(_)) { cases } else { cases.saturating_sub(1) }
}

/// Whether an arm is in more than one case.
fn repeats(cases: &[Case]) -> bool {
    let twice = |arm: &dyn Fn(&Case) -> Option<usize>| {
        let mut all: Vec<usize> = cases.iter().filter_map(arm).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        all.len() < count
    };
    twice(&|case| Some(case.a)) || twice(&|case| case.b)
}
