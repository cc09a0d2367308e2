//! E0301, E0805, E0807, W0504, W1001 and W1002: the test exists, suits the claim, and has enough runs to
//! decide it.

use super::range::is_ratio;
use super::{Scope, arms_in, at, name};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink, Span};
use crate::kinds::metric::{MetricKind, Scale};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Expectation, Over, Relation, Summary, alternatives, keys};
use crate::spec::suggest::{listed, nearest};

/// The test of a claim; E0301 if it is unknown.
pub fn statistic(claim: &Claim, sink: &mut Sink) -> Option<&'static StatisticKind> {
    let found = statistic::find(&claim.test);
    if found.is_none() {
        let error = Diagnostic::error("E0301", format!("unknown test `{}`", claim.test));
        let error = at(claim, keys::Claim::test.name, error, "");
        let names = || statistic::KINDS.iter().map(|test| test.kind.name);
        let span = claim.marks.get(keys::Claim::test.name).map(|mark| mark.value);
        sink.emit(match (nearest(&claim.test, names()), span) {
            (Some(near), Some(span)) => {
                error.help(format!("did you mean `{near}`?")).fix(span, format!("\"{near}\""))
            }
            _ => error.help(format!("the tests are {}", listed(names()))),
        });
    }
    found
}

/// E0807: the test accepts this number of arms, this type of metric and this summary.
pub fn suits(claim: &Claim, test: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    let (word, measured) = (test.kind.name, metric.kind.name);
    let others = |fits: &dyn Fn(&StatisticKind) -> bool| {
        let takes = |other: &&&StatisticKind| {
            other.takes.contains(&metric.scale) && other.arms.takes(claim.sides.len()) && fits(other)
        };
        statistic::KINDS.iter().filter(takes).map(|other| other.kind.name).collect::<Vec<_>>()
    };
    let advice = |lead: &str| match others(&|_| true).as_slice() {
        // Only ranks are meaningful, and a single arm has no rank.
        [] => format!(
            "no test compares `{measured}` of one arm with a number: write `compare` with two arms for \
             `arm`, \
             `expect = \"a {} b\"` and `test = \"mann_whitney\"`",
            claim.expect.relation.symbol()
        ),
        names => format!("{lead} {}", listed(names.iter().copied())),
    };
    let is_trend = matches!(claim.over, Some(Over::Trend(_)));
    let is_trend_of_shares = is_trend && test.method == Method::Newcombe && claim.sides.len() == 1;
    let bootstrap = test.method == Method::StratifiedBootstrap;
    let (key, message, help) = if !test.takes.contains(&metric.scale) {
        (
            keys::Claim::test.name,
            format!("`{word}` does not take `{measured}`"),
            advice("tests that take it are"),
        )
    } else if !test.arms.takes(claim.sides.len()) && !is_trend_of_shares {
        let arms = if claim.sides.len() == 1 { "one arm with a number" } else { "two arms" };
        (keys::Claim::test.name, format!("`{word}` does not compare {arms}"), advice("tests that do are"))
    } else if claim.summary == Summary::Iqm && !bootstrap {
        let message = format!("`{word}` does not take the interquartile mean");
        ("summary", message, "remove `summary`, or write `test = \"stratified_bootstrap\"`".to_owned())
    } else if is_trend && test.method != Method::Welch && !is_trend_of_shares {
        let message = format!("`{word}` does not take a trend");
        let help = "write `test = \"welch\"` over runs, or `test = \"newcombe\"` for shares of one policy at \
            each point";
        (keys::Claim::over.name, message, help.to_owned())
    } else if claim.over == Some(Over::Mean) && !takes_strata(test.method) {
        let message = format!("`{word}` does not take the mean over several arms");
        (keys::Claim::over.name, message, "write `over = \"each\"`, or `test = \"welch\"`".to_owned())
    } else if metric.source.is_of_a_run() && test.unit() == Unit::Episode {
        let message =
            format!("`{word}` does not take `{measured}`: it compares episodes, which have no such value");
        (keys::Claim::test.name, message, "write `test = \"welch\"`".to_owned())
    } else if claim.baseline.is_some()
        && test.unit() == Unit::Episode
        && test.method != Method::EpisodeBootstrap
    {
        let message = format!("`{word}` does not take a baseline: it counts successes");
        let key = claim.key_of_baseline();
        (key, message, "write `test = \"episode_bootstrap\"`, or `test = \"welch\"` over runs".to_owned())
    } else if is_changed(claim) && test.method == Method::ProbabilityOfImprovement {
        let message = format!("`{word}` takes no multiple of an arm and no distance from it");
        (Expectation::RIGHT, message, "write `a > b`, or `test = \"welch\"`".to_owned())
    } else if claim.expect.factor != 1.0 && metric.scale == Scale::Success && test.unit() == Unit::Episode {
        let message = format!("`{word}` does not take a multiple of an arm");
        (Expectation::RIGHT, message, "write `test = \"welch\"`".to_owned())
    } else {
        return;
    };
    sink.emit(at(claim, key, Diagnostic::error("E0807", message), "").help(help));
}

/// Whether an arm has a factor or an offset.
fn is_changed(claim: &Claim) -> bool {
    claim.expect.factor != 1.0 || claim.expect.offset.as_ref().is_some_and(|offset| offset.si != 0.0)
}

/// Whether a test supports the mean over several arms.
fn takes_strata(method: Method) -> bool {
    matches!(method, Method::Welch | Method::StratifiedBootstrap | Method::ProbabilityOfImprovement)
}

/// W1002: a claim about two arms of a paper states the paper's effect size, so that data without the effect
/// contradict it.
pub fn states_an_effect(claim: &Claim, test: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    let states = claim.margin.is_some() || is_changed(claim) || claim.expect.relation == Relation::Equal;
    if claim.paper.is_none() || claim.sides.len() < 2 || states {
        return;
    }
    let message = format!("`{}` states no effect: arms that do not differ cannot refute it", claim.id);
    let warning = at(claim, keys::Claim::expect.name, Diagnostic::warning("W1002", message), "by how much?");
    // For "less", the effect is subtracted.
    let is_less = matches!(claim.expect.relation, Relation::Less | Relation::AtMost);
    let written = claim.expect.written();
    let sign = if is_less { '-' } else { '+' };
    let margin = |number: &str, sum: &str| {
        format!("for example `margin = {number}` or `expect = \"{written} {sign} {sum}\"`")
    };
    let example = match metric.unit {
        _ if test.method == Method::ProbabilityOfImprovement => {
            "for example `margin = 0.2`: the probability must then be 0.2 beyond one half".to_owned()
        }
        _ if is_ratio(claim) => margin("0.2", "0.2"),
        // Returns and counts have no known scale.
        "" => {
            let (left, relation) = (&claim.expect.left, claim.expect.relation.symbol());
            let other = claim.expect.right_written(str::to_owned);
            let factor = if is_less { 0.8 } else { 1.2 };
            format!("for example `expect = \"{left} {relation} {factor} * {other}\"`")
        }
        "%" => margin("\"20 %\"", "20 %"),
        unit => margin(&format!("\"0.2 {unit}\""), &format!("0.2 {unit}")),
    };
    sink.emit(warning.help(format!("state the smallest effect that the claim is about, {example}")));
}

/// What a claim can decide with one run per arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lone {
    /// A test over runs cannot decide it.
    Undecided,
    /// A test over episodes only compares individual policies.
    Policies,
}

/// E0805: the arms have enough runs for the test. One run is a quick look, whose claims stay open unless they
/// count.
pub fn runs(
    claim: &Claim,
    test: &StatisticKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) -> Option<Lone> {
    let fewest = arms_in(cases, scope).into_iter().min_by_key(|arm| arm.runs)?;
    let [alpha, opposite] = levels(claim, scope, cases);
    let (word, least) = (test.kind.name, (test.least)(alpha));
    match fewest.runs {
        1 if test.unit() == Unit::Episode => return Some(Lone::Policies),
        1 if !scope.counted => return Some(Lone::Undecided),
        runs if runs >= least => {
            let refuting = (test.least)(opposite);
            if test.unit() == Unit::Seed && runs < refuting {
                let message =
                    format!("no result of {runs} seeds can refute `{}`: it can pass, but not fail", claim.id);
                let warning = at(
                    claim,
                    keys::Claim::over.name,
                    Diagnostic::warning("W1001", message),
                    "one comparison in so many",
                );
                sink.emit(
                    warning.help(format!(
                        "write `seeds = {refuting}` or more in `[sweep]`, or compare fewer arms"
                    )),
                );
            }
            return None;
        }
        _ => {}
    }
    let message = format!("too few seeds: `{word}` at alpha {} needs {least} per arm", short(alpha));
    let error = Diagnostic::error("E0805", message);
    let remark = format!(
        "the arm `{}` has {} {}",
        name(fewest.points),
        fewest.runs,
        if fewest.runs == 1 { "seed" } else { "seeds" }
    );
    let error = at(claim, keys::Claim::test.name, error, &remark);
    let error = error.help(format!(
        "write `seeds = {least}` or more in `[sweep]`, or take a test of one policy's episodes"
    ));
    sink.emit(match scope.seeds {
        Some(span) => error.note(span, "the seeds"),
        None => error,
    });
    None
}

/// The levels at which a comparison must be decided for the claim to pass and to fail.
pub fn levels(claim: &Claim, scope: &Scope, cases: &[Case]) -> [f64; 2] {
    let points = scope.points();
    let alternatives = alternatives(claim, &points, cases);
    let comparisons = alternatives.iter().map(|alternative| alternative.cases.len()).max().unwrap_or(1);
    let holding = match claim.over {
        Some(Over::AtLeast(count)) => count,
        Some(Over::AtMost(count)) => count + 1,
        _ => 1,
    };
    let refuting = (alternatives.len() + 1).saturating_sub(holding).max(1);
    let levels = [refuting, holding * comparisons].map(|divisor| claim.alpha / divisor as f64);
    match claim.over {
        Some(Over::None(_) | Over::AtMost(_)) => [levels[1], levels[0]],
        _ => levels,
    }
}

/// W0504: claims whose arms have one run each, reported once, at the seeds.
pub fn one_seed(lone: Lone, claims: &[String], place: Option<Span>) -> Diagnostic {
    let names = listed(claims.iter().map(String::as_str));
    let (message, help) = match lone {
        Lone::Undecided => (
            format!("one seed in a claim: a test over runs will leave {names} not established"),
            "give `[sweep]` more seeds, or say in `[allow]` why one is meant",
        ),
        Lone::Policies => (
            format!(
                "one seed in a claim: {names} will speak of these policies, not of the methods that made them"
            ),
            "give `[sweep]` more seeds and test over them, or say in `[allow]` why one is meant",
        ),
    };
    let warning = Diagnostic::warning("W0504", message).help(help);
    place.map_or(warning.clone(), |span| warning.at(span, "one run per arm"))
}
