//! The figures of a report: each turns the report's input into a drawing with a caption and sources.

pub mod contact_forces;
pub mod endings;
pub mod learning_curves;
pub mod skeleton;
pub mod speed;
pub mod standing;
pub mod suite;
pub mod time_lapse;
pub mod torques;
pub mod window;

use super::model::ReportInput;
use super::plot::{Anchor, Drawing, Ink, Stroke, drawing::text_width};
use super::source::Source;
use crate::plan::Training;

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name: the file is `REPORT/ID.svg`.
    pub id: String,
    /// Its title.
    pub title: String,
    /// What it shows, with n.
    pub caption: String,
    /// The drawing.
    pub drawing: Drawing,
    /// The stages it was made from.
    pub sources: Vec<Source>,
}

/// The figures that the input has data for; for a suite, those it requests or the default ones.
pub fn all(input: &ReportInput) -> Vec<Figure> {
    if input.suite.is_some() {
        return suite::all(input);
    }
    let curves =
        [Training::First, Training::FineTuning].map(|training| learning_curves::figure(input, training));
    let mut figures: Vec<Figure> = curves.into_iter().flatten().collect();
    figures.extend([endings::figure(input), speed::figure(input)].into_iter().flatten());
    figures.extend((0..input.arms.len()).filter_map(|arm| time_lapse::figure(input, arm)));
    figures.extend(torques::figure(input));
    figures.extend(contact_forces::figure(input));
    figures
}

/// An entry of a legend: the look of its line and its text.
pub struct Entry {
    /// The look of the line.
    pub stroke: Stroke,
    /// The text.
    pub text: String,
}

/// Draws a legend in one row that starts at this position.
pub fn legend(drawing: &mut Drawing, [mut x, y]: [f64; 2], entries: &[Entry]) {
    for entry in entries {
        drawing.line(&[[x, y - 4.0], [x + 22.0, y - 4.0]], entry.stroke);
        drawing.text([x + 28.0, y], &entry.text, Ink::Text, Anchor::Start);
        x += 28.0 + text_width(&entry.text, 12.0) + 22.0;
    }
}
