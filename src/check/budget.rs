//! E0507 and W0508 between keys of the learner: the parts of a rollout divide it, and the actor has its turn.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::spec::Value;
use crate::syntax::Layer;

/// `learn.environments` divides `learn.rollout`, and a minibatch is not larger than a rollout.
pub fn batches_divide_the_rollout(subject: &Subject, sink: &mut Sink) {
    let count = |path: &str| match subject.value(path) {
        Some(Value::Count(count)) => Some(*count),
        _ => None,
    };
    let Some(rollout) = count("learn.rollout") else { return };
    let mut report = |path: &str, message: String, advice: String| {
        let mut diagnostic = Diagnostic::error("E0507", message);
        if let Some(place) = subject.place(path) {
            diagnostic = diagnostic.at(place, "");
        }
        if let Some(mark) = subject.marks.get("learn.rollout").filter(|mark| mark.layer != Layer::Default) {
            diagnostic = diagnostic.note(mark.value, "the samples of an update");
        }
        sink.emit(diagnostic.help(advice));
    };
    if let Some(environments) = count("learn.environments")
        && (environments == 0 || rollout % environments != 0)
    {
        let message = format!("`learn.environments` ({environments}) does not divide `learn.rollout` ({rollout})");
        let nearest = (1..=environments.min(rollout)).rev().find(|count| rollout % count == 0).unwrap_or(1);
        report("learn.environments", message, format!("the next lower number that divides it is {nearest}"));
    }
    if let Some(minibatch) = count("learn.minibatch")
        && minibatch > rollout
    {
        let message = format!("`learn.minibatch` ({minibatch}) is larger than `learn.rollout` ({rollout})");
        report("learn.minibatch", message, "a minibatch is drawn from one rollout".to_owned());
    }
}

/// The budget has updates beyond the critic's warm-up.
pub fn the_actor_has_its_turn(subject: &Subject, sink: &mut Sink) {
    let count = |key: &str| match subject.value(&format!("learn.{key}")) {
        Some(Value::Count(count)) => Some(*count),
        _ => None,
    };
    let (Some(samples), Some(rollout), Some(warm_up)) = (count("samples"), count("rollout"), count("warm_up")) else {
        return;
    };
    // Without samples nothing is meant to be learned.
    let updates = samples.div_ceil(rollout.max(1));
    if samples == 0 || updates > warm_up {
        return;
    }
    let message = format!(
        "the actor never learns: {samples} samples are {updates} updates of {rollout}, and in the first {warm_up} \
         only the critic does"
    );
    let mut diagnostic = Diagnostic::warning("W0508", message);
    if let Some(place) = subject.place("learn.samples") {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some(mark) = subject.marks.get("learn.warm_up") {
        diagnostic = diagnostic.note(mark.value, "the updates of the critic alone");
    }
    let (fewer, more) = (updates / 5, (warm_up + 1) * rollout);
    sink.emit(diagnostic.help(format!("write `learn.warm_up = {fewer}`, or learn from {more} samples or more")));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn environments_share_a_rollout_evenly() {
        let spec =
            |environments: u32| format!("[learn]\nrollout = 8192\nminibatch = 128\nenvironments = {environments}");
        assert_eq!(found(batches_divide_the_rollout, &spec(64), None), []);
        let diagnostics = found(batches_divide_the_rollout, &spec(60), None);
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(
            (diagnostics[0].code, diagnostics[0].help[0].as_str()),
            ("E0507", "the next lower number that divides it is 32")
        );
    }

    #[test]
    fn a_budget_within_the_warm_up_is_warned_of() {
        let spec = |samples: u32| format!("[learn]\nrollout = 8192\nwarm_up = 5\nsamples = {samples}");
        assert_eq!(found(the_actor_has_its_turn, &spec(0), None), []);
        assert_eq!(found(the_actor_has_its_turn, &spec(40_961), None), []);
        let diagnostics = found(the_actor_has_its_turn, &spec(40_000), None);
        assert_eq!(diagnostics.len(), 1);
        let told = (diagnostics[0].code, diagnostics[0].help[0].as_str());
        assert_eq!(told, ("W0508", "write `learn.warm_up = 1`, or learn from 49152 samples or more"));
    }

    #[test]
    fn a_minibatch_is_a_part_of_a_rollout() {
        let text = "[learn]\nrollout = 512\nminibatch = 1024\nenvironments = 8";
        assert_eq!(found(batches_divide_the_rollout, text, None).len(), 1);
    }
}
