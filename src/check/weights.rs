//! W0501: a reward term that weighs nothing.

use super::Subject;
use crate::diag::{Diagnostic, Sink};

/// No reward term has the weight zero.
pub fn weights_are_not_zero(subject: &Subject, sink: &mut Sink) {
    for (path, term) in subject.terms("reward") {
        if term.si_if("weight") != Some(0.0) {
            continue;
        }
        let mut diagnostic = Diagnostic::warning("W0501", format!("`{path}` has no effect: its weight is zero"));
        if let Some(place) = subject.place(&format!("{path}.weight")) {
            diagnostic = diagnostic.at(place, "");
        }
        sink.emit(diagnostic.help("drop the term with `enabled = false`"));
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn only_zero_is_zero() {
        let text = "[reward.torque]\nweight = 0.0\n[reward.contact_force]\nweight = 0.1";
        let found = found(weights_are_not_zero, text, None);
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].code, found[0].message.as_str()),
            ("W0501", "`reward.torque` has no effect: its weight is zero")
        );
    }
}
