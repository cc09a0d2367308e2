//! A drawing of lines, areas, texts and dots in pixels, x to the right and y down.

use super::palette::Ink;

/// A position in pixels.
pub type Point = [f64; 2];

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width in pixels.
    pub width: f64,
    /// Lengths of dash and gap in pixels, for a dashed line.
    pub dash: Option<[f64; 2]>,
    /// Opacity from 0 to 1.
    pub opacity: f64,
}

impl Stroke {
    /// An opaque solid line.
    pub fn solid(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: None, opacity: 1.0 }
    }

    /// A dashed line.
    pub fn dashed(ink: Ink, width: f64) -> Self {
        Self { dash: Some([4.0, 3.0]), ..Self::solid(ink, width) }
    }

    /// The same line with this opacity.
    pub fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// The anchor point of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// A text.
#[derive(Clone, Debug, PartialEq)]
pub struct Words {
    /// The position of the anchor on the base line.
    pub at: Point,
    /// The text.
    pub text: String,
    /// Its colour.
    pub ink: Ink,
    /// Its size in pixels.
    pub size: f64,
    /// The anchor.
    pub anchor: Anchor,
    /// Whether it is rotated to read upwards.
    pub upwards: bool,
    /// Whether it is bold.
    pub bold: bool,
}

/// An element of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A line through points.
    Line(Vec<Point>, Stroke),
    /// A filled area and its opacity.
    Area(Vec<Point>, Ink, f64),
    /// A dot: centre, radius, colour, opacity.
    Dot(Point, f64, Ink, f64),
    /// A text.
    Words(Words),
}

/// A drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
    /// Description for screen readers and tool tips.
    pub title: String,
    /// Text of the `metadata` element.
    pub metadata: String,
    /// From back to front.
    pub items: Vec<Item>,
}

impl Drawing {
    /// An empty drawing.
    pub fn new(width: f64, height: f64, title: impl Into<String>) -> Self {
        Self { width, height, title: title.into(), metadata: String::new(), items: Vec::new() }
    }

    /// Adds a line through points, interrupted at points that are not finite.
    pub fn line(&mut self, points: &[Point], stroke: Stroke) {
        for piece in points.split(|point| !point[0].is_finite() || !point[1].is_finite()) {
            if piece.len() > 1 {
                self.items.push(Item::Line(piece.to_vec(), stroke));
            }
        }
    }

    /// Adds a filled area.
    pub fn area(&mut self, points: &[Point], ink: Ink, opacity: f64) {
        self.items.push(Item::Area(points.to_vec(), ink, opacity));
    }

    /// Adds a filled rectangle between two corners.
    pub fn rectangle(&mut self, a: Point, b: Point, ink: Ink, opacity: f64) {
        self.area(&[a, [b[0], a[1]], b, [a[0], b[1]]], ink, opacity);
    }

    /// Adds a dot.
    pub fn dot(&mut self, centre: Point, radius: f64, ink: Ink, opacity: f64) {
        self.items.push(Item::Dot(centre, radius, ink, opacity));
    }

    /// Adds an unfilled circle.
    pub fn ring(&mut self, centre: Point, radius: f64, stroke: Stroke) {
        const CORNERS: usize = 24;
        let corner = |at: usize| {
            let angle = std::f64::consts::TAU * at as f64 / CORNERS as f64;
            [centre[0] + radius * libm::cos(angle), centre[1] + radius * libm::sin(angle)]
        };
        let points: Vec<Point> = (0..=CORNERS).map(corner).collect();
        self.line(&points, stroke);
    }

    /// Adds a text of 12 pixels; the returned reference allows changes.
    pub fn text(&mut self, at: Point, text: impl Into<String>, ink: Ink, anchor: Anchor) -> &mut Words {
        let words = Words { at, text: text.into(), ink, size: 12.0, anchor, upwards: false, bold: false };
        self.items.push(Item::Words(words));
        match self.items.last_mut() {
            Some(Item::Words(words)) => words,
            _ => unreachable!("the words were pushed just now"),
        }
    }
}

/// Estimated width of a text in pixels in common sans-serif fonts.
pub fn text_width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}
