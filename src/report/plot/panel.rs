//! A panel: an area of a drawing with two axes.

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Point, Stroke, text_width};
use super::palette::Ink;

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// Right edge.
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Lower edge.
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// The cell of a grid of `columns` by `rows` over this area, with gaps in pixels between cells.
    pub fn cell(&self, [columns, rows]: [usize; 2], [column, row]: [usize; 2], gap: [f64; 2]) -> Self {
        let width = (self.width - gap[0] * (columns - 1) as f64) / columns as f64;
        let height = (self.height - gap[1] * (rows - 1) as f64) / rows as f64;
        let left = self.left + column as f64 * (width + gap[0]);
        let top = self.top + row as f64 * (height + gap[1]);
        Self { left, top, width, height }
    }
}

/// An area with axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The plot area; ticks and labels are outside.
    pub area: Area,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
}

impl Panel {
    /// The position of a value, clamped to the area vertically.
    pub fn place(&self, x: f64, y: f64) -> Point {
        let height = self.y.share(y).clamp(-0.02, 1.02);
        let across = self.area.left + self.area.width * self.x.share(x);
        [across, self.area.bottom() - self.area.height * if y.is_finite() { height } else { f64::NAN }]
    }

    /// Draws grid, ticks and labels, with `title` above the area.
    pub fn frame(&self, drawing: &mut Drawing, title: &str) {
        let Area { left, top, .. } = self.area;
        let (right, bottom) = (self.area.right(), self.area.bottom());
        for (value, text) in &self.y.ticks {
            let y = self.place(0.0, *value)[1];
            drawing.line(&[[left, y], [right, y]], Stroke::solid(Ink::Grid, 1.0));
            drawing.text([left - 6.0, y + 4.0], text, Ink::Muted, Anchor::End).size = 11.0;
        }
        drawing.line(&[[left, bottom], [right, bottom]], Stroke::solid(Ink::Muted, 1.0));
        self.frame_below(drawing);
        let middle = 0.5 * (top + bottom);
        if !self.y.label.is_empty() {
            let label = drawing.text([left - 42.0, middle], &self.y.label, Ink::Muted, Anchor::Middle);
            (label.upwards, label.size) = (true, 11.0);
        }
        if !title.is_empty() {
            drawing.text([left, top - 9.0], title, Ink::Text, Anchor::Start).bold = true;
        }
    }

    /// Draws ticks and label of the horizontal axis.
    fn frame_below(&self, drawing: &mut Drawing) {
        let bottom = self.area.bottom();
        for (value, text) in &self.x.ticks {
            let x = self.place(*value, 0.0)[0];
            drawing.line(&[[x, bottom], [x, bottom + 4.0]], Stroke::solid(Ink::Muted, 1.0));
            drawing.text([x, bottom + 16.0], text, Ink::Muted, Anchor::Middle).size = 11.0;
        }
        if !self.x.label.is_empty() {
            let centre = self.area.left + 0.5 * self.area.width;
            drawing.text([centre, bottom + 32.0], &self.x.label, Ink::Muted, Anchor::Middle).size = 11.0;
        }
    }

    /// Draws ticks and label of a second horizontal axis below the first, with the same ends.
    pub fn second_scale(&self, drawing: &mut Drawing, axis: &Axis) {
        let bottom = self.area.bottom() + 38.0;
        drawing
            .line(&[[self.area.left, bottom], [self.area.right(), bottom]], Stroke::solid(Ink::Muted, 1.0));
        Panel {
            area: Area { height: bottom - self.area.top, ..self.area },
            x: axis.clone(),
            y: self.y.clone(),
        }
        .frame_below(drawing);
    }

    /// Draws a line through values.
    pub fn line(&self, drawing: &mut Drawing, values: &[(f64, f64)], stroke: Stroke) {
        let points: Vec<Point> = values.iter().map(|(x, y)| self.place(*x, *y)).collect();
        drawing.line(&points, stroke);
    }

    /// Draws a horizontal line across the panel.
    pub fn level(&self, drawing: &mut Drawing, y: f64, stroke: Stroke) {
        drawing.line(&[self.place(self.x.range[0], y), self.place(self.x.range[1], y)], stroke);
    }

    /// Writes labels over horizontal lines at these heights, at the left end, below lines at the upper edge;
    /// moved apart if they would overlap.
    pub fn level_labels(&self, drawing: &mut Drawing, labels: &[(f64, String)], ink: Ink) {
        let top = self.area.top;
        let beside = |line: f64| if line - top < 15.0 { line + 12.0 } else { line - 4.0 };
        let wanted: Vec<f64> = labels.iter().map(|(y, _)| beside(self.place(0.0, *y)[1])).collect();
        let places = spread(&wanted, 12.0, [top + 10.0, self.area.bottom() - 4.0]);
        for ((_, text), y) in labels.iter().zip(places) {
            drawing.text([self.area.left + 5.0, y], text, ink, Anchor::Start).size = 11.0;
        }
    }

    /// Fills the area between two curves with common x values.
    pub fn band(&self, drawing: &mut Drawing, values: &[(f64, f64, f64)], ink: Ink, opacity: f64) {
        let upper = values.iter().map(|(x, _, high)| self.place(*x, *high));
        let lower = values.iter().rev().map(|(x, low, _)| self.place(*x, *low));
        let points: Vec<Point> = upper.chain(lower).collect();
        drawing.area(&points, ink, opacity);
    }

    /// Writes labels to the right of the area at these heights, moved apart if they would overlap.
    pub fn end_labels(&self, drawing: &mut Drawing, labels: &[(f64, String, Ink)]) {
        let wanted: Vec<f64> = labels.iter().map(|(y, ..)| self.place(0.0, *y)[1]).collect();
        let places = spread(&wanted, 13.0, [self.area.top, self.area.bottom()]);
        for ((_, text, ink), y) in labels.iter().zip(places) {
            drawing.text([self.area.right() + 6.0, y + 4.0], text, *ink, Anchor::Start);
        }
    }
}

/// The width in pixels that [`Panel::end_labels`] needs to the right of the area for these names.
pub fn label_room(names: &[String]) -> f64 {
    12.0 + names.iter().map(|name| text_width(name, 12.0)).fold(0.0, f64::max)
}

/// Moves positions at least `gap` apart, keeping their order, and within the limits if they fit.
fn spread(wanted: &[f64], gap: f64, limits: [f64; 2]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let mut places = wanted.to_vec();
    let mut least = limits[0];
    for index in &order {
        places[*index] = places[*index].max(least);
        least = places[*index] + gap;
    }
    let mut most = limits[1];
    for index in order.iter().rev() {
        places[*index] = places[*index].min(most);
        most = places[*index] - gap;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_placed_with_the_axis_upwards() {
        let area = Area { left: 10.0, top: 20.0, width: 100.0, height: 50.0 };
        let panel = Panel { area, x: Axis::over("", [0.0, 10.0], 5), y: Axis::over("", [-1.0, 1.0], 4) };
        assert_eq!(panel.place(0.0, -1.0), [10.0, 70.0]);
        assert_eq!(panel.place(5.0, 0.0), [60.0, 45.0]);
        assert!(panel.place(5.0, f64::NAN)[1].is_nan());
    }

    #[test]
    fn labels_that_would_touch_move_apart_and_keep_their_order() {
        assert_eq!(spread(&[50.0, 49.0, 10.0], 13.0, [0.0, 100.0]), vec![62.0, 49.0, 10.0]);
        assert_eq!(spread(&[99.0, 98.0], 13.0, [0.0, 100.0]), vec![100.0, 87.0]);
    }

    #[test]
    fn the_cells_of_a_grid_cover_the_area() {
        let area = Area { left: 0.0, top: 0.0, width: 210.0, height: 100.0 };
        let cell = area.cell([2, 1], [1, 0], [10.0, 0.0]);
        assert_eq!(cell, Area { left: 110.0, top: 0.0, width: 100.0, height: 100.0 });
    }
}
