//! W0503: randomization by more than a factor of two.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};

/// Every scale stays within `[0.5, 2]`.
pub fn scales_are_moderate(subject: &Subject, sink: &mut Sink) {
    for (path, term) in subject.randomizations() {
        let Some(scale) = term.sampler_if("scale") else { continue };
        let [low, high] = scale.bounds();
        if low >= 0.5 && high <= 2.0 {
            continue;
        }
        let message = format!("`{path}` scales by {} to {}, more than a factor of two", short(low), short(high));
        let mut diagnostic = Diagnostic::warning("W0503", message);
        if let Some(place) = subject.place(&format!("{path}.scale")) {
            diagnostic = diagnostic.at(place, "");
        }
        sink.emit(diagnostic.help("the paper randomizes by 0.6 to 1.4"));
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn a_factor_of_two_is_still_moderate() {
        assert_eq!(found(scales_are_moderate, "[randomize.link_mass]\nscale = [0.5, 2.0]", None), []);
        let diagnostics = found(scales_are_moderate, "[randomize.link_mass]\nscale = [0.25, 1.4]", None);
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(
            (diagnostics[0].code, diagnostics[0].message.as_str()),
            ("W0503", "`randomize.link_mass` scales by 0.25 to 1.4, more than a factor of two")
        );
    }
}
