//! E0507 between keys of the learner: the parts of a rollout divide it.

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
    fn a_minibatch_is_a_part_of_a_rollout() {
        let text = "[learn]\nrollout = 512\nminibatch = 1024\nenvironments = 8";
        assert_eq!(found(batches_divide_the_rollout, text, None).len(), 1);
    }
}
