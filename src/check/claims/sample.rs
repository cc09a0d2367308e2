//! E0301, E0805, E0807 and W0504: the test is there, suits the claim, and has enough runs to decide it.

use super::{Scope, arms_in, at, name};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::metric::MetricKind;
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Over, Summary};
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

/// E0805 and W0504: how many runs the arms have. One run is a quick look, whose claims stay open, unless they count.
pub fn runs(claim: &Claim, test: &StatisticKind, (scope, cases): (&Scope, &[Case]), sink: &mut Sink) {
    let arms = arms_in(cases, scope);
    let Some(fewest) = arms.into_iter().min_by_key(|arm| arm.runs) else { return };
    let (word, least) = (test.kind.name, (test.least)(claim.alpha));
    let diagnostic = match fewest.runs {
        1 if test.unit == Unit::Episode => {
            let message = "one seed in a claim: it speaks of these policies, not of the methods that made them";
            let help = "give `[sweep]` more seeds and test over them, or say in `[allow]` why one is meant";
            Diagnostic::warning("W0504", message).help(help)
        }
        1 if least > 1 && !scope.counted => {
            let message =
                format!("one seed in a claim: `{word}` cannot decide it, it will be reported as not established");
            let help = format!("give `[sweep]` {least} seeds or more, or say in `[allow]` why one is meant");
            Diagnostic::warning("W0504", message).help(help)
        }
        runs if runs < least => {
            let message = format!("too few seeds: `{word}` at alpha {} needs {least} per arm", claim.alpha);
            let help = format!("write `seeds = {least}` or more in `[sweep]`, or take a test of one policy's episodes");
            Diagnostic::error("E0805", message).help(help)
        }
        _ => return,
    };
    let seeds = if fewest.runs == 1 { "one seed".to_owned() } else { format!("{} seeds", fewest.runs) };
    let remark = format!("the arm `{}` has {seeds}", name(fewest.points));
    let diagnostic = at(claim, "test", diagnostic, &remark);
    sink.emit(match scope.seeds {
        Some(span) => diagnostic.note(span, "the seeds"),
        None => diagnostic,
    });
}
