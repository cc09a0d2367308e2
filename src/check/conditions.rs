//! E0101, E0104, E0204, E0210, E0211 and E0508: speed grids and parameter sets of evaluations.

use super::Subject;
use super::subject::{short, whole};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::parameter_sets::Parameter;
use crate::kinds::evaluate::{Evaluation, ParameterSets, Speeds};
use crate::spec::Section;
use crate::spec::suggest::listed;

/// Maximum number of episodes of one evaluation.
const MOST: f64 = 1e5;

/// The conditions of an evaluation are valid.
pub fn conditions_can_be_listed(subject: &Subject, sink: &mut Sink) {
    for (path, table) in subject.terms::<Evaluation>() {
        if table.is::<Speeds>() {
            speeds(subject, &path, table, sink);
        } else if table.is::<ParameterSets>() {
            parameter_sets(subject, &path, table, sink);
        }
    }
}

/// A grid has both ends and a step that divides their distance; without a grid there is a list.
fn speeds(subject: &Subject, path: &str, table: Section, sink: &mut Sink) {
    let grid = [Speeds::from, Speeds::to, Speeds::step];
    let missing: Vec<&str> = grid.into_iter().filter(|key| !table.holds(*key)).map(|key| key.name).collect();
    let listed_speeds = table.value(Speeds::speeds);
    let (none, listed_only) =
        (missing.len() == grid.len(), missing.len() == grid.len() && listed_speeds.is_some());
    if let ([_, ..], false) = (missing.as_slice(), listed_only) {
        let (message, help) = match none {
            true => (
                format!("`{path}` has no speeds"),
                "add `from`, `to` and `step`, or a list `speeds = [\"0.1 m/s\", \"0.3 m/s\"]`",
            ),
            false => (
                format!("the grid of `{path}` is incomplete: missing {}", listed(missing)),
                "a grid has `from`, `to` and `step`, such as `from = \"0 m/s\"`, `to = \"0.5 m/s\"` and \
                 `step = \"0.1 m/s\"`",
            ),
        };
        sink.emit(at(subject, path, Diagnostic::error("E0101", message)).help(help));
        return;
    }
    let grid_length = if none { 0.0 } else { grid_of(subject, path, table, sink).unwrap_or(0.0) };
    let listed = listed_speeds.map_or(0.0, |speeds| speeds.len() as f64);
    let episodes = (grid_length + listed) * table.value(Speeds::repeats).unwrap_or(1) as f64;
    if episodes > MOST {
        let message = format!("`{path}` has {} episodes, but the maximum is {MOST}", short(episodes));
        let help = "raise `step` or lower `repeats`";
        sink.emit(at(subject, &Speeds::repeats.below(path), Diagnostic::error("E0204", message)).help(help));
    }
}

/// The number of speeds of a grid; `None` after a mistake.
fn grid_of(subject: &Subject, path: &str, table: Section, sink: &mut Sink) -> Option<f64> {
    let (from, to, step) = (table.value(Speeds::from)?, table.value(Speeds::to)?, table.value(Speeds::step)?);
    if from > to {
        let message = format!(
            "the grid of `{path}` is empty: `from` is {} and `to` is {} \
                               m/s",
            short(from),
            short(to)
        );
        let error = at(subject, &Speeds::from.below(path), Diagnostic::error("E0210", message));
        sink.emit(error.help("exchange `from` and `to`"));
        return None;
    }
    let steps = (to - from) / step;
    if let Some(steps) = whole(steps) {
        return Some(steps + 1.0);
    }
    let message = format!(
        "the step does not divide the grid: from {} to {} m/s are {} steps of {} m/s",
        short(from),
        short(to),
        short(steps),
        short(step)
    );
    let error = at(subject, &Speeds::step.below(path), Diagnostic::error("E0508", message));
    let ends = [steps.floor(), steps.ceil()].map(|steps| format!("\"{} m/s\"", short(from + steps * step)));
    sink.emit(error.help(format!("write `to = {}` or `to = {}`", ends[0], ends[1])));
    None
}

/// The scale is a range of positive factors, and no parameter is repeated.
fn parameter_sets(subject: &Subject, path: &str, table: Section, sink: &mut Sink) {
    let place = ParameterSets::scale.below(path);
    let swapped = match table.value(ParameterSets::scale).unwrap_or_default().as_slice() {
        [low, high] if low > high && *high > 0.0 => Some(format!("[{high}, {low}]")),
        _ => None,
    };
    let problem = match table.value(ParameterSets::scale).unwrap_or_default().as_slice() {
        [low, _] if *low <= 0.0 => Some(("E0211", "a factor must be greater than zero".to_owned())),
        [low, high] if low >= high => Some((
            "E0210",
            format!(
                "the range of `scale` is empty: from {} to \
                                    {}",
                short(*low),
                short(*high)
            ),
        )),
        _ => None,
    };
    if let Some((code, message)) = problem {
        let help = "write the lower factor first, for example `scale = [0.7, 1.3]`";
        let error = at(subject, &place, Diagnostic::error(code, message)).help(help);
        sink.emit(match swapped {
            Some(range) => subject.edited(&place, range, error),
            None => error,
        });
    }
    let parameters = table.value(ParameterSets::parameters).unwrap_or_default();
    let names: Vec<&str> = parameters.into_iter().map(Parameter::word).collect();
    if names.is_empty() {
        let error = Diagnostic::error("E0204", format!("`{path}` has no parameters"));
        let help = "add a parameter, or remove `parameters` to use the paper's eight";
        sink.emit(at(subject, &ParameterSets::parameters.below(path), error).help(help));
    }
    for (index, name) in names.iter().enumerate().filter(|(index, name)| names[..*index].contains(name)) {
        let error = Diagnostic::error("E0104", format!("duplicate parameter `{name}`"));
        sink.emit(at(subject, &format!("{path}.parameters.{index}"), error).help("remove one of the two"));
    }
}

/// A diagnostic at the place of a value.
fn at(subject: &Subject, path: &str, diagnostic: Diagnostic) -> Diagnostic {
    match subject.place(path) {
        Some(place) => diagnostic.at(place, ""),
        None => diagnostic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn codes(keys: &str) -> Vec<&'static str> {
        found(conditions_can_be_listed, &format!("[evaluate.grid]\n{keys}"), None)
            .iter()
            .map(|found| found.code)
            .collect()
    }

    #[test]
    fn a_grid_of_speeds_ends_on_its_end() {
        let grid = |to: f64| {
            codes(&format!("kind = \"speeds\"\nfrom = 0.02\nto = {to:?}\nstep = 0.02\nrepeats = 1"))
        };
        assert!(grid(0.5).is_empty() && grid(0.02).is_empty());
        assert_eq!((grid(0.51), grid(0.0)), (vec!["E0508"], vec!["E0210"]));
    }

    #[test]
    fn speeds_come_from_a_whole_grid_or_from_a_list() {
        let codes = |keys: &str| codes(&format!("kind = \"speeds\"\nrepeats = 1\n{keys}"));
        assert_eq!(codes(""), ["E0101"]);
        assert_eq!(codes("from = 0.1\nspeeds = 0.2"), ["E0101"]);
        assert!(codes("speeds = 0.2").is_empty());
        assert_eq!(codes("from = 0.0\nto = 10.0\nstep = 0.00001"), ["E0204"]);
    }

    #[test]
    fn a_scale_is_a_positive_range_and_parameters_stand_once() {
        let codes = |scale: &str, names: &str| {
            codes(&format!("kind = \"parameter_sets\"\nscale = {scale}\nparameters = {names}"))
        };
        let one = "[\"link_mass\"]";
        assert!(codes("[1, 2]", one).is_empty());
        assert_eq!(codes("[2, 1]", one), ["E0210"]);
        assert_eq!(codes("[0, 1]", one), ["E0211"]);
        assert_eq!(codes("[1, 1]", one), ["E0210"], "no parameter would differ");
        assert_eq!(codes("[1, 2]", "[\"link_mass\", \"link_com\", \"link_mass\"]"), ["E0104"]);
        assert_eq!(codes("[1, 2]", "[]"), ["E0204"]);
    }
}
