//! The figures of a report: each turns a report's input into one drawing with its caption and sources.

pub mod contact_forces;
pub mod endings;
pub mod learning_curves;
pub mod skeleton;
pub mod speed;
pub mod suite;
pub mod time_lapse;
pub mod torques;
pub mod window;

use serde::{Deserialize, Serialize};

use super::model::ReportInput;
use super::plot::{Anchor, Drawing, Ink, Stroke, drawing::text_width};
use crate::plan::Training;

/// A stage that a figure or a table was made from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Source {
    /// Name of the arm's spec.
    pub arm: String,
    /// The stage.
    pub stage: String,
}

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name: the file is `NAME/ID.svg`.
    pub id: String,
    /// Its title.
    pub title: String,
    /// What is to be seen, with n.
    pub caption: String,
    /// The drawing.
    pub drawing: Drawing,
    /// The stages that it was made from.
    pub sources: Vec<Source>,
}

/// The figures that the input has data for; of a suite those that it asks for, or the usual ones.
pub fn all(input: &ReportInput) -> Vec<Figure> {
    if input.suite.is_some() {
        return suite::all(input);
    }
    let curves = [Training::First, Training::FineTuning].map(|training| learning_curves::figure(input, training));
    let mut figures: Vec<Figure> = curves.into_iter().flatten().collect();
    figures.extend([endings::figure(input), speed::figure(input)].into_iter().flatten());
    figures.extend((0..input.arms.len()).filter_map(|arm| time_lapse::figure(input, arm)));
    figures.extend(torques::figure(input));
    figures.extend(contact_forces::figure(input));
    figures
}

/// An entry of a legend: how its line looks and what it says.
pub struct Entry {
    /// The line.
    pub stroke: Stroke,
    /// The words.
    pub text: String,
}

/// Draws a legend in one row that starts at a place.
pub fn legend(drawing: &mut Drawing, [mut x, y]: [f64; 2], entries: &[Entry]) {
    for entry in entries {
        drawing.line(&[[x, y - 4.0], [x + 22.0, y - 4.0]], entry.stroke);
        drawing.text([x + 28.0, y], &entry.text, Ink::Text, Anchor::Start);
        x += 28.0 + text_width(&entry.text, 12.0) + 22.0;
    }
}

/// The sources of one stage in every arm that has it.
fn sources(input: &ReportInput, stage_of: impl Fn(&super::model::Arm) -> Vec<String>) -> Vec<Source> {
    let of_arm = |arm: &super::model::Arm| -> Vec<Source> {
        stage_of(arm).into_iter().map(|stage| Source { arm: arm.name.clone(), stage }).collect()
    };
    input.arms.iter().flat_map(of_arm).collect()
}
