//! Survival over the two axes of a suite: a square for every arm.

use super::Figure;
use crate::report::model::ReportInput;
use crate::report::plot::{Anchor, Drawing, Ink, drawing::text_width};
use crate::report::statistics::summary::mean;
use crate::report::suite::{Group, groups, table, varying};

/// The figure's name.
pub const ID: &str = "survival_grid";

const CELL: [f64; 2] = [112.0, 54.0];

/// The figure, when the arms differ on exactly two axes and were evaluated.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let groups = groups(input);
    let axes = varying(input, &groups);
    let [(row_axis, rows), (column_axis, columns)] = axes.as_slice() else { return None };
    let stage = table::stages(&groups).into_iter().next()?;
    let left = 34.0 + rows.iter().map(|row| text_width(row, 12.0)).fold(text_width(row_axis, 12.0), f64::max);
    let size = [left + CELL[0] * columns.len() as f64 + 20.0, 70.0 + CELL[1] * rows.len() as f64 + 12.0];
    let mut drawing = Drawing::new(size[0], size[1], "Survival by arm");
    let centre = left + 0.5 * CELL[0] * columns.len() as f64;
    drawing.text([centre, 22.0], *column_axis, Ink::Muted, Anchor::Middle);
    drawing.text([left - 12.0, 48.0], *row_axis, Ink::Muted, Anchor::End);
    for (at, column) in columns.iter().enumerate() {
        drawing.text([left + CELL[0] * (at as f64 + 0.5), 48.0], *column, Ink::Text, Anchor::Middle);
    }
    for (down, row) in rows.iter().enumerate() {
        let top = 58.0 + CELL[1] * down as f64;
        drawing.text([left - 12.0, top + 0.5 * CELL[1] + 4.0], *row, Ink::Text, Anchor::End);
        for (across, column) in columns.iter().enumerate() {
            let is_here =
                |group: &&Group<'_>| group.point(row_axis) == Some(*row) && group.point(column_axis) == Some(*column);
            let group = groups.iter().find(is_here);
            square(&mut drawing, [left + CELL[0] * across as f64, top], group.map(|group| (group, stage.as_str())));
        }
    }
    let runs = groups.iter().map(|group| table::values(group, &stage, "survival").len()).sum::<usize>();
    Some(Figure {
        id: ID.to_string(),
        title: "Survival by arm".to_string(),
        caption: format!(
            "Share of the episodes of `{stage}` that end at their time limit, mean over the seeds of an arm, with the lowest and the highest seed; {runs} runs. A robot that stands still survives."
        ),
        drawing,
        sources: table::sources(&groups, &stage),
    })
}

/// A square: darker where more survives, with the numbers in it.
fn square(drawing: &mut Drawing, [left, top]: [f64; 2], arm: Option<(&Group<'_>, &str)>) {
    let values = arm.map(|(group, stage)| table::values(group, stage, "survival")).unwrap_or_default();
    let corners = [[left + 2.0, top + 2.0], [left + CELL[0] - 2.0, top + CELL[1] - 2.0]];
    let middle = [left + 0.5 * CELL[0], top + 0.5 * CELL[1]];
    let Some(share) = mean(&values) else {
        drawing.rectangle(corners[0], corners[1], Ink::Shade, 0.5);
        let words = if arm.is_some() { "no result" } else { "\u{2013}" };
        drawing.text([middle[0], middle[1] + 4.0], words, Ink::Muted, Anchor::Middle);
        return;
    };
    drawing.rectangle(corners[0], corners[1], Ink::Arm(0), 0.06 + 0.44 * share);
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    drawing.text([middle[0], middle[1]], format!("{} %", percent(share)), Ink::Text, Anchor::Middle).bold = true;
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = format!("{} to {}, n = {}", percent(low), percent(high), values.len());
    drawing.text([middle[0], middle[1] + 16.0], range, Ink::Text, Anchor::Middle).size = 10.0;
}
