//! Heat maps: a metric over the last two axes of a suite, one cell per arm. The points of other axes have
//! separate grids.

use super::View;
use crate::report::figure::Figure;
use crate::report::group::{Group, varying};
use crate::report::metric::Metric;
use crate::report::plot::axis::written;
use crate::report::plot::{Anchor, Drawing, Ink, drawing::text_width};
use crate::report::suite::table;
use crate::report::wording::capitalised;
use crate::statistics::summary::mean;

/// The name of the survival figure.
pub const ID: &str = "survival_grid";

/// Size of a cell in pixels; long numbers make it wider.
const CELL: [f64; 2] = [112.0, 54.0];
/// Most cells across the page: a longer axis runs downwards.
const MOST_COLUMNS: usize = 8;
/// Room above a grid's cells, and between two grids.
const HEAD: f64 = 58.0;
const BETWEEN: f64 = 22.0;

/// A metric over the arms.
struct Map<'a> {
    metric: Metric,
    stage: String,
    /// Axis and points of the rows; the axis has no name if the arms differ on one axis only.
    rows: (&'a str, Vec<&'a str>),
    columns: (&'a str, Vec<&'a str>),
    /// The arms of each grid, with its title.
    grids: Vec<(String, Vec<usize>)>,
    /// The values with the faintest and the darkest colour.
    range: [f64; 2],
    /// Size of a cell in pixels.
    cell: [f64; 2],
}

/// Survival, if the arms differ on two or more axes and were evaluated.
pub fn survival(view: &View) -> Option<Figure> {
    let stage = view.stage(|measured| !measured.evaluation.episodes.is_empty())?;
    let map = map(view, Metric::named("survival")?, stage, 2)?;
    let runs: usize =
        view.groups.iter().map(|group| table::values(group, &map.stage, "survival").len()).sum();
    let caption = format!(
        "Share of the episodes of `{}` that end at their time limit, mean over the seeds of an arm, with the \
         lowest and the highest seed; {runs} runs. A robot that stands still survives.",
        map.stage
    );
    figure(view, &map, "Survival by arm", caption)
}

/// Any metric, if the arms differ on at least one axis and were evaluated.
pub fn metric(view: &View) -> Option<Figure> {
    let (stage, name) = view.wanted.about.first()?.rsplit_once('.')?;
    let map = map(view, Metric::named(name)?, stage.to_owned(), 1)?;
    let values: Vec<f64> = view.groups.iter().flat_map(|group| table::values(group, stage, name)).collect();
    if values.is_empty() {
        return None;
    }
    let unit = if map.metric.unit.is_empty() { String::new() } else { format!(" in {}", map.metric.unit) };
    let title = format!("{} by arm", capitalised(map.metric.label));
    let caption = format!(
        "{}{unit} in `{stage}`, mean over the seeds of an arm of each run's mean over its episodes, with the \
         lowest and the highest seed; {} runs. Darker is more, from {} to {}.",
        capitalised(map.metric.label),
        values.len(),
        map.shown(map.range[0]),
        map.shown(map.range[1]),
    );
    figure(view, &map, &title, caption)
}

fn map<'a>(view: &View<'a>, metric: Metric, stage: String, least: usize) -> Option<Map<'a>> {
    let mut axes = varying(view.input, &view.groups);
    if axes.len() < least {
        return None;
    }
    let mut columns = axes.pop()?;
    let mut rows = axes.pop().unwrap_or(("", vec![""]));
    if columns.1.len() > MOST_COLUMNS && columns.1.len() > rows.1.len() && !rows.0.is_empty() {
        std::mem::swap(&mut rows, &mut columns);
    }
    let mut grids: Vec<(String, Vec<usize>)> = Vec::new();
    for (at, group) in view.groups.iter().enumerate() {
        let points = axes.iter().filter_map(|(axis, _)| Some(format!("{axis}={}", group.point(axis)?)));
        let title = points.collect::<Vec<_>>().join(", ");
        match grids.iter_mut().find(|(known, _)| *known == title) {
            Some((_, arms)) => arms.push(at),
            None => grids.push((title, vec![at])),
        }
    }
    let means = || view.groups.iter().filter_map(|group| mean(&table::values(group, &stage, metric.name)));
    let range = match metric.unit {
        "%" => [0.0, 1.0],
        _ => [means().fold(f64::INFINITY, f64::min), means().fold(f64::NEG_INFINITY, f64::max)],
    };
    let mut map = Map { metric, stage, rows, columns, grids, range, cell: CELL };
    let widest = view.groups.iter().map(|group| text_width(&map.spread(group), 10.0)).fold(0.0, f64::max);
    map.cell[0] = map.cell[0].max(widest + 12.0);
    Some(map)
}

fn figure(view: &View, map: &Map, title: &str, caption: String) -> Option<Figure> {
    let (row_axis, rows) = (map.rows.0, &map.rows.1);
    let left = 34.0 + rows.iter().map(|row| text_width(row, 12.0)).fold(text_width(row_axis, 12.0), f64::max);
    let height = HEAD + map.cell[1] * rows.len() as f64 + BETWEEN;
    let titled = if map.grids.len() > 1 { 20.0 } else { 0.0 };
    let count = map.grids.len() as f64;
    let width = left + map.cell[0] * map.columns.1.len() as f64 + 20.0;
    let mut drawing = Drawing::new(width, count * (height + titled), title);
    for (at, (name, arms)) in map.grids.iter().enumerate() {
        let top = at as f64 * (height + titled);
        if titled > 0.0 {
            drawing.text([12.0, top + 20.0], name, Ink::Text, Anchor::Start).bold = true;
        }
        let arms: Vec<&Group<'_>> = arms.iter().map(|arm| &view.groups[*arm]).collect();
        map.draw(&mut drawing, [left, top + titled], &arms);
    }
    let (id, sources) = (view.id(), view.sources(&map.stage));
    Some(Figure { id, title: title.to_owned(), caption, drawing, sources })
}

impl Map<'_> {
    /// A value in the metric's unit, without the unit.
    fn shown(&self, value: f64) -> String {
        let scale = if self.metric.unit == "%" { 100.0 } else { 1.0 };
        written(scale * value, self.metric.digits)
    }

    /// `25 to 75, n = 3`: the lowest and the highest seed, if there are several.
    fn spread(&self, arm: &Group<'_>) -> String {
        let values = table::values(arm, &self.stage, self.metric.name);
        if values.len() < 2 {
            return format!("n = {}", values.len());
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        format!("{} to {}, n = {}", self.shown(low), self.shown(high), values.len())
    }

    /// Draws the grid of some arms with its headings.
    fn draw(&self, drawing: &mut Drawing, [left, top]: [f64; 2], arms: &[&Group<'_>]) {
        let ((row_axis, rows), (column_axis, columns)) = (&self.rows, &self.columns);
        let centre = left + 0.5 * self.cell[0] * columns.len() as f64;
        drawing.text([centre, top + 22.0], *column_axis, Ink::Muted, Anchor::Middle);
        drawing.text([left - 12.0, top + 48.0], *row_axis, Ink::Muted, Anchor::End);
        for (at, column) in columns.iter().enumerate() {
            drawing.text(
                [left + self.cell[0] * (at as f64 + 0.5), top + 48.0],
                *column,
                Ink::Text,
                Anchor::Middle,
            );
        }
        for (down, row) in rows.iter().enumerate() {
            let y = top + HEAD + self.cell[1] * down as f64;
            drawing.text([left - 12.0, y + 0.5 * self.cell[1] + 4.0], *row, Ink::Text, Anchor::End);
            for (across, column) in columns.iter().enumerate() {
                let is_here = |group: &&&Group<'_>| {
                    (row_axis.is_empty() || group.point(row_axis) == Some(*row))
                        && group.point(column_axis) == Some(*column)
                };
                self.square(
                    drawing,
                    [left + self.cell[0] * across as f64, y],
                    arms.iter().find(is_here).copied(),
                );
            }
        }
    }

    /// Draws a cell: darker for larger values, with the numbers in it.
    fn square(&self, drawing: &mut Drawing, [left, top]: [f64; 2], arm: Option<&Group<'_>>) {
        let values = arm.map(|group| table::values(group, &self.stage, self.metric.name)).unwrap_or_default();
        let corners = [[left + 2.0, top + 2.0], [left + self.cell[0] - 2.0, top + self.cell[1] - 2.0]];
        let middle = [left + 0.5 * self.cell[0], top + 0.5 * self.cell[1]];
        let Some(value) = mean(&values) else {
            drawing.rectangle(corners[0], corners[1], Ink::Shade, 0.5);
            let words = if arm.is_some() { "no result" } else { "\u{2013}" };
            drawing.text([middle[0], middle[1] + 4.0], words, Ink::Muted, Anchor::Middle);
            return;
        };
        let share = if self.range[1] > self.range[0] {
            (value - self.range[0]) / (self.range[1] - self.range[0])
        } else {
            0.5
        };
        drawing.rectangle(corners[0], corners[1], Ink::Arm(0), 0.06 + 0.44 * share.clamp(0.0, 1.0));
        let unit = if self.metric.unit.is_empty() { String::new() } else { format!(" {}", self.metric.unit) };
        let words = format!("{}{unit}", self.shown(value));
        drawing.text([middle[0], middle[1]], words, Ink::Text, Anchor::Middle).bold = true;
        let range = arm.map_or(String::new(), |arm| self.spread(arm));
        drawing.text([middle[0], middle[1] + 16.0], range, Ink::Text, Anchor::Middle).size = 10.0;
    }
}
