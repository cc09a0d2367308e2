//! W0503: randomization by more than a factor of two.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::parameter_sets::Parameter;
use crate::kinds::evaluate::{Evaluation, ParameterSets};
use crate::kinds::randomize::link_mass::LinkMass;

/// Every scale is within `[0.5, 2]`: those drawn in training and evaluations, and those of parameter sets.
pub fn scales_are_moderate(subject: &Subject, sink: &mut Sink) {
    let drawn = subject.randomizations().into_iter();
    let drawn = drawn.filter_map(|(path, term)| Some((path, term.value(LinkMass::scale)?.bounds())));
    let sets = subject.terms::<Evaluation>().into_iter().filter(|(_, table)| table.is::<ParameterSets>());
    let sets = sets.filter_map(|(path, table)| {
        // A delay is not a property of the robot's design.
        let parameters = table.value(ParameterSets::parameters).unwrap_or_default();
        let of_robots = parameters.iter().any(|parameter| *parameter != Parameter::ActionDelay);
        let scale = table.value(ParameterSets::scale).filter(|_| of_robots)?;
        Some((path, <[f64; 2]>::try_from(scale).ok()?))
    });
    for (path, [low, high]) in drawn.chain(sets) {
        if low >= 0.5 && high <= 2.0 {
            continue;
        }
        let message =
            format!("`{path}` scales by {} to {}, more than a factor of two", short(low), short(high));
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
            format!(
                "[evaluate.sets]\nkind = \"parameter_sets\"\nscale = {scale}\nparameters = [\"{parameter}\"]"
            )
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
