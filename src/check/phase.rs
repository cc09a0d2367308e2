//! E0105: settings of a missing phase action.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;

/// Settings of a phase action require one.
pub fn phase_actions_are_there(subject: &Subject, sink: &mut Sink) {
    if subject.at(Position::phase_action).is_none() || subject.at(Position::phase_modulation) != Some(false) {
        return;
    }
    let mut diagnostic = Diagnostic::error("E0105", "`phase_action` has no effect without a phase action");
    if let Some(place) = subject.place(&Position::phase_action.path()) {
        diagnostic = diagnostic.at(place, "no effect");
    }
    if let Some(mark) = subject.marks.get(&Position::phase_modulation.path()) {
        diagnostic = diagnostic.note(mark.value, "switched off here");
    }
    sink.emit(diagnostic.help("remove it, or write `phase_modulation = true`"));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn a_phase_action_that_is_switched_off_does_nothing() {
        let codes = |keys: &str| -> Vec<&str> {
            let diagnostics = found(phase_actions_are_there, &format!("[action]\n{keys}"), None);
            diagnostics.iter().map(|diagnostic| diagnostic.code).collect()
        };
        assert_eq!(codes("phase_modulation = false\nphase_action = \"share\""), ["E0105"]);
        assert!(codes("phase_modulation = true\nphase_action = \"share\"").is_empty());
        assert!(codes("phase_modulation = false").is_empty());
    }
}
