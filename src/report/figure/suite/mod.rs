//! The figures of a suite: those listed in `report.figures`, or without a list all figures with data.

pub mod ankle_torque;
pub mod claims;
pub mod contact_forces;
pub mod failure_deciles;
pub mod failure_loadings;
pub mod grid;
pub mod learning_curves;
pub mod return_histogram;
pub mod speeds;
pub mod time_lapse;

use super::Figure;
use crate::report::group::{Group, groups};
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::source::Source;
use crate::spec::suite::Wanted;

/// The figures of a suite without a list; those without data are omitted.
const USUAL: [&str; 8] = [
    "learning_curves",
    "claims",
    "survival_grid",
    "speeds",
    "time_lapse",
    "return_histogram",
    "failure_loadings",
    "failure_deciles",
];

/// What a figure is drawn from.
#[derive(Clone, Debug)]
pub struct View<'a> {
    /// The report's input.
    pub input: &'a ReportInput,
    /// The arms with their runs.
    pub groups: Vec<Group<'a>>,
    /// Name and subject of the requested figure.
    pub wanted: Wanted,
}

/// Draws a figure, if there is data for it.
type Draw = fn(&View) -> Option<Figure>;

/// The figures in the requested order.
pub fn all(input: &ReportInput) -> Vec<Figure> {
    let named: Vec<Wanted> = match input.figures.as_slice() {
        [] => USUAL.iter().map(|name| Wanted::parse(name)).collect(),
        names => names.iter().map(|name| Wanted::parse(name)).collect(),
    };
    let draw = |wanted: Wanted| {
        let draw = drawer(&wanted.name)?;
        draw(&View { input, groups: groups(input), wanted })
    };
    named.into_iter().filter_map(draw).collect()
}

fn drawer(name: &str) -> Option<Draw> {
    let draw: Draw = match name {
        "ankle_torque" => ankle_torque::figure,
        "claims" => claims::figure,
        "contact_forces" => contact_forces::figure,
        "failure_deciles" => failure_deciles::figure,
        "failure_loadings" => failure_loadings::figure,
        "learning_curves" => learning_curves::figure,
        "metric_grid" => grid::metric,
        "return_histogram" => return_histogram::figure,
        "speeds" => speeds::figure,
        "survival_grid" => grid::survival,
        "time_lapse" => time_lapse::figure,
        _ => return None,
    };
    Some(draw)
}

impl View<'_> {
    /// The figure's name in its report: `metric_grid_evaluate_nominal_speed`.
    pub fn id(&self) -> String {
        let plain = |text: &String| text.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let parts = [&self.wanted.name].into_iter().chain(&self.wanted.about).map(plain);
        parts.collect::<Vec<_>>().join("_")
    }

    /// The requested stage, or else the first one for which the predicate holds in a run.
    pub fn stage(&self, or_else: impl Fn(&Measured) -> bool) -> Option<String> {
        if let Some(about) = self.wanted.about.first() {
            return Some(about.clone());
        }
        let runs = self.groups.iter().flat_map(|group| &group.runs);
        let mut measured = runs.flat_map(|run| &run.evaluations);
        measured.find(|measured| or_else(measured)).map(|measured| measured.stage.clone())
    }

    /// The evaluations of a stage by arm, with their runs.
    pub fn measured(&self, stage: &str) -> Vec<(usize, &Arm, &Measured)> {
        let mut found = Vec::new();
        for (place, group) in self.groups.iter().enumerate() {
            found.extend(group.runs.iter().filter_map(|run| Some((place, *run, evaluated(run, stage)?))));
        }
        found
    }

    /// The runs that have a stage, as sources.
    pub fn sources(&self, stage: &str) -> Vec<Source> {
        crate::report::group::sources(&self.groups, stage)
    }
}

/// The evaluation of a stage with at least one episode.
pub fn evaluated<'r>(run: &'r Arm, stage: &str) -> Option<&'r Measured> {
    run.evaluations
        .iter()
        .find(|measured| measured.stage == stage && !measured.evaluation.episodes.is_empty())
}

/// `one policy` or `3 policies`.
fn policies(count: usize) -> String {
    if count == 1 { "one policy".to_owned() } else { format!("{count} policies") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::suite::figures::FIGURES;

    #[test]
    fn every_figure_that_a_suite_may_name_is_drawn_by_somebody() {
        for (name, _) in FIGURES {
            assert!(drawer(name).is_some(), "{name}");
        }
        assert!(USUAL.iter().all(|name| FIGURES.iter().any(|(known, _)| known == name)));
    }

    #[test]
    fn a_figure_about_something_has_a_name_that_a_file_can_have() {
        let input = ReportInput::default();
        let view = |text| View { input: &input, groups: Vec::new(), wanted: Wanted::parse(text) };
        assert_eq!(view("claims").id(), "claims");
        assert_eq!(view("metric_grid:evaluate.nominal.speed").id(), "metric_grid_evaluate_nominal_speed");
    }
}
