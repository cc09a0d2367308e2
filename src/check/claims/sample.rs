//! E0301, E0805, E0807 and W0504: the test is there, suits the claim, and has enough runs to decide it.

use super::{Scope, arms_in, at, name};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink, Span};
use crate::kinds::metric::MetricKind;
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Over, Points, Summary, alternatives};
use crate::spec::suggest::{listed, nearest};

/// The test that is named; E0301 when there is none of the name.
pub fn statistic(claim: &Claim, sink: &mut Sink) -> Option<&'static StatisticKind> {
    let found = statistic::find(&claim.test);
    if found.is_none() {
        let error = Diagnostic::error("E0301", format!("unknown test `{}`", claim.test));
        let error = at(claim, "test", error, "");
        let names = || statistic::KINDS.iter().map(|test| test.kind.name);
        let span = claim.marks.get("test").map(|mark| mark.value);
        sink.emit(match (nearest(&claim.test, names()), span) {
            (Some(near), Some(span)) => error.help(format!("did you mean `{near}`?")).fix(span, format!("\"{near}\"")),
            _ => error.help(format!("the tests are {}", listed(names()))),
        });
    }
    found
}

/// E0807: the test takes this many arms, this sort of metric, this summary.
pub fn suits(claim: &Claim, test: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    let (word, measured) = (test.kind.name, metric.kind.name);
    let others = |fits: &dyn Fn(&StatisticKind) -> bool| {
        let takes = |other: &&&StatisticKind| {
            other.takes.contains(&metric.scale) && other.arms.takes(claim.sides.len()) && fits(other)
        };
        listed(statistic::KINDS.iter().filter(takes).map(|other| other.kind.name))
    };
    let bootstrap = test.method == Method::StratifiedBootstrap;
    let (key, message, help) = if !test.takes.contains(&metric.scale) {
        (
            "test",
            format!("`{word}` does not take `{measured}`"),
            format!("tests that take it are {}", others(&|_| true)),
        )
    } else if !test.arms.takes(claim.sides.len()) {
        let arms = if claim.sides.len() == 1 { "one arm with a number" } else { "two arms" };
        ("test", format!("`{word}` does not compare {arms}"), format!("tests that do are {}", others(&|_| true)))
    } else if claim.summary == Summary::Iqm && !bootstrap {
        let message = format!("`{word}` does not take the interquartile mean");
        ("summary", message, "remove `summary`, or write `test = \"stratified_bootstrap\"`".to_owned())
    } else if claim.over == Some(Over::Mean) && !bootstrap && test.method != Method::ProbabilityOfImprovement {
        let message = format!("`{word}` does not take the mean over several arms");
        ("over", message, "write `over = \"each\"`, or `test = \"stratified_bootstrap\"`".to_owned())
    } else {
        return;
    };
    sink.emit(at(claim, key, Diagnostic::error("E0807", message), "").help(help));
}

/// What one run per arm leaves of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lone {
    /// A test over runs cannot decide it.
    Undecided,
    /// A test over episodes speaks of policies.
    Policies,
}

/// E0805: the arms have enough runs for the test. One run is a quick look, whose claims stay open unless they count.
pub fn runs(claim: &Claim, test: &StatisticKind, (scope, cases): (&Scope, &[Case]), sink: &mut Sink) -> Option<Lone> {
    let fewest = arms_in(cases, scope).into_iter().min_by_key(|arm| arm.runs)?;
    let alpha = strictest(claim, scope, cases);
    let (word, least) = (test.kind.name, (test.least)(alpha));
    match fewest.runs {
        1 if test.unit == Unit::Episode => return Some(Lone::Policies),
        1 if !scope.counted => return Some(Lone::Undecided),
        runs if runs >= least => return None,
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
    let error = at(claim, "test", error, &remark);
    let error =
        error.help(format!("write `seeds = {least}` or more in `[sweep]`, or take a test of one policy's episodes"));
    sink.emit(match scope.seeds {
        Some(span) => error.note(span, "the seeds"),
        None => error,
    });
    None
}

/// The level at which a comparison must be decided for the claim to pass: with alternatives that of the correction for
/// their number.
fn strictest(claim: &Claim, scope: &Scope, cases: &[Case]) -> f64 {
    let points: Vec<&Points> = scope.arms.iter().map(|arm| arm.points).collect();
    let alternatives = alternatives(claim, &points, cases);
    let most = alternatives.iter().map(|alternative| alternative.cases.len()).max();
    claim.alpha
        / match claim.over {
            Some(Over::Some(_)) => alternatives.len(),
            Some(Over::None(_)) => most.unwrap_or(1),
            _ => 1,
        } as f64
}

/// W0504: claims whose arms have one run each, told once, where the seeds are given.
pub fn one_seed(lone: Lone, claims: &[String], place: Option<Span>) -> Diagnostic {
    let names = listed(claims.iter().map(String::as_str));
    let (message, help) = match lone {
        Lone::Undecided => (
            format!("one seed in a claim: a test over runs will leave {names} not established"),
            "give `[sweep]` more seeds, or say in `[allow]` why one is meant",
        ),
        Lone::Policies => (
            format!("one seed in a claim: {names} will speak of these policies, not of the methods that made them"),
            "give `[sweep]` more seeds and test over them, or say in `[allow]` why one is meant",
        ),
    };
    let warning = Diagnostic::warning("W0504", message).help(help);
    place.map_or(warning.clone(), |span| warning.at(span, "one run per arm"))
}
