//! W0503: randomization by more than a factor of two.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};

/// Every scale stays within `[0.5, 2]`: those that training and evaluations draw, and those of parameter sets.
pub fn scales_are_moderate(subject: &Subject, sink: &mut Sink) {
    let drawn = subject.randomizations().into_iter();
    let drawn = drawn.filter_map(|(path, term)| Some((path, term.sampler_if("scale")?.bounds())));
    let sets = subject.terms("evaluate").into_iter().filter_map(|(path, table)| {
        let sets = subject.kind(&path) == Some("parameter_sets") && table.has("scale");
        // A delay is no property of a design.
        let of_robots = || table.texts("parameters").iter().any(|name| name != "action_delay");
        let numbers = (sets && of_robots()).then(|| table.numbers("scale"))?;
        Some((path, <[f64; 2]>::try_from(numbers).ok()?))
    });
    for (path, [low, high]) in drawn.chain(sets) {
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
    fn parameter_sets_are_looked_at_too() {
        let sets = |scale: &str, parameter: &str| {
            format!("[evaluate.sets]\nkind = \"parameter_sets\"\nscale = {scale}\nparameters = [\"{parameter}\"]")
        };
        assert_eq!(found(scales_are_moderate, &sets("[1, 2]", "link_mass"), None), []);
        assert_eq!(found(scales_are_moderate, &sets("[1, 3]", "action_delay"), None), []);
        let diagnostics = found(scales_are_moderate, &sets("[1, 3]", "link_mass"), None);
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(diagnostics[0].message, "`evaluate.sets` scales by 1 to 3, more than a factor of two");
    }

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
