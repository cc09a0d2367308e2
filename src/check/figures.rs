//! E0804: the arguments of a suite's figures exist: at least one arm has the stage, and the metric is known.

use super::checked::CheckedArm;
use super::claims::measure::stages;
use crate::diag::{Diagnostic, Sink, Span};
use crate::kinds::metric::{self, Source};
use crate::spec::suggest::{listed, nearest};
use crate::spec::suite::Wanted;
use crate::spec::suite::figures::About;

/// Checks every figure with an argument.
pub fn produced(figures: &[(Wanted, Span)], arms: &[CheckedArm], sink: &mut Sink) {
    let mut known: Vec<String> = arms.iter().flat_map(|arm| stages(&arm.arm.experiment.table)).collect();
    known.sort();
    known.dedup();
    let (evaluations, trainings): (Vec<String>, Vec<String>) =
        known.into_iter().partition(|stage| stage.contains('.'));
    for (wanted, place) in figures {
        let known = if wanted.takes() == Some(About::Training) { &trainings } else { &evaluations };
        let found = wanted.about.iter().filter_map(|about| mistake(wanted, about, known));
        found.for_each(|(error, fix)| {
            let error = error.at(*place, "");
            sink.emit(match fix {
                Some(text) => {
                    error.help(format!("did you mean `{text}`?")).fix(*place, format!("\"{text}\""))
                }
                None => error,
            });
        });
    }
}

/// What is wrong with one argument of a figure, and the suggested text.
fn mistake(wanted: &Wanted, about: &str, known: &[String]) -> Option<(Diagnostic, Option<String>)> {
    let metric = matches!(wanted.takes(), Some(About::Metric | About::MetricOrNothing));
    let (stage, name) = match about.rsplit_once('.') {
        Some((stage, name)) if metric => (stage, Some(name)),
        None if metric => ("", Some(about)),
        _ => (about, None),
    };
    let instead = |part: &str, near: &str| {
        let meant = |own: &String| if own == about { own.replacen(part, near, 1) } else { own.clone() };
        format!("{}:{}", wanted.name, wanted.about.iter().map(meant).collect::<Vec<_>>().join(","))
    };
    if let Some(name) = name.filter(|name| !is_of_episodes(name)) {
        let error = Diagnostic::error("E0804", format!("`{name}` is not a metric of evaluations"));
        let names = metric::KINDS.iter().map(|metric| metric.kind.name).filter(|name| is_of_episodes(name));
        return Some(match nearest(name, names) {
            Some(near) => (error, Some(instead(name, near))),
            None => (error.help("`specforge list metric` prints the metrics"), None),
        });
    }
    if known.iter().any(|known| known == stage) {
        return None;
    }
    if stage.is_empty() {
        let error = Diagnostic::error("E0804", format!("missing stage of the metric `{about}`"));
        return Some((
            error.help(format!("write for example `{}:evaluate.nominal.{about}`", wanted.name)),
            None,
        ));
    }
    let what = if wanted.takes() == Some(About::Training) { "training" } else { "stage" };
    let error = Diagnostic::error("E0804", format!("no arm has the {what} `{stage}`"));
    Some(match nearest(stage, known.iter().map(String::as_str)) {
        Some(near) => (error, Some(instead(stage, near))),
        None => (
            error.help(format!("the {what}s of the arms are {}", listed(known.iter().map(String::as_str)))),
            None,
        ),
    })
}

fn is_of_episodes(name: &str) -> bool {
    metric::find(name)
        .is_some_and(|metric| !metric.source.is_of_a_run() && !matches!(metric.source, Source::Task))
}
