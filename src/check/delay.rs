//! E0505: the longest delay that can be drawn fits the stored history of commands.

use super::Subject;
use super::subject::duration;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::evaluate::parameter_sets::Parameter;
use crate::kinds::evaluate::{Evaluation, ParameterSets};
use crate::kinds::randomize::action_delay::ActionDelay;

/// Length of the command history in s.
pub const HISTORY: f64 = 0.1;

/// The delay times its largest randomization is at most [`HISTORY`].
pub fn delays_fit_the_history(subject: &Subject, sink: &mut Sink) {
    let (Some(delay), Some((longest, drawn))) = (subject.at(Position::delay), longest(subject)) else {
        return;
    };
    if longest <= HISTORY * (1.0 + 1e-9) {
        return;
    }
    let (most, kept) = (duration(longest), duration(HISTORY));
    let message = format!("the action delay can reach {most}, but the maximum is {kept}");
    let mut diagnostic = Diagnostic::error("E0505", message);
    if let Some(place) = subject.place(&Position::delay.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some((path, scale)) = drawn
        && let Some(place) = subject.place(&ActionDelay::scale.below(&path))
    {
        diagnostic = diagnostic.note(place, format!("scaled by up to {scale}"));
    }
    let fitting = libm::floor(HISTORY * delay / longest * 1e4 * (1.0 + 1e-9)) * 1e-4;
    sink.emit(diagnostic.help(format!("use a delay of at most {}", duration(fitting))));
}

/// The longest delay in s that can be drawn, and the draw with its largest factor.
pub(super) fn longest(subject: &Subject) -> Option<(f64, Option<(String, f64)>)> {
    let delay = subject.at(Position::delay)?;
    let drawn = subject
        .randomizations()
        .into_iter()
        .filter(|(_, term)| term.is::<ActionDelay>())
        .filter_map(|(path, term)| Some((path, term.value(ActionDelay::scale)?.bounds()[1])))
        .chain(sets(subject))
        .max_by(|(_, a), (_, b)| a.total_cmp(b));
    Some((delay * drawn.as_ref().map_or(1.0, |(_, scale)| *scale), drawn))
}

/// The largest factors of evaluations whose parameter sets scale the delay.
fn sets<'a>(subject: &Subject<'a>) -> impl Iterator<Item = (String, f64)> + use<'a> {
    subject.terms::<Evaluation>().into_iter().filter_map(|(path, table)| {
        let scaled = table.value(ParameterSets::parameters)?;
        let scale = table.value(ParameterSets::scale).filter(|_| scaled.contains(&Parameter::ActionDelay))?;
        Some((path, *scale.last()?))
    })
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn the_randomization_counts() {
        let spec = |delay: &str| {
            format!(
                "action = {{ delay = {delay} }}\n[randomize.action_delay]\nkind = \"action_delay\"\nscale = \
                 [0.5, 1.5]"
            )
        };
        assert_eq!(found(delays_fit_the_history, &spec("0.004"), None), []);
        assert_eq!(found(delays_fit_the_history, &spec("0.066"), None), []);
        let sets =
            "[evaluate.sets]\nkind = \"parameter_sets\"\nscale = [0, 3]\nparameters = [\"action_delay\"]";
        let of_sets = found(delays_fit_the_history, &format!("action = {{ delay = 0.04 }}\n{sets}"), None);
        assert_eq!(of_sets.iter().map(|found| found.code).collect::<Vec<_>>(), ["E0505"]);
        let diagnostics = found(delays_fit_the_history, &spec("0.08"), None);
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(
            (diagnostics[0].code, diagnostics[0].message.as_str()),
            ("E0505", "the action delay can reach 120 ms, but the maximum is 100 ms")
        );
    }
}
