//! Writes a drawing as an SVG document: fixed number format and no dates, so that the output is reproducible.

use std::fmt::Write as _;

use super::drawing::{Anchor, Drawing, Item, Point, Stroke, Words};
use super::outline::simplified;
use super::palette::style_sheet;
use crate::escape::xml;

impl Drawing {
    /// The drawing as an SVG document.
    pub fn to_svg(&self) -> String {
        document(self)
    }
}

fn document(drawing: &Drawing) -> String {
    let (width, height) = (coordinate(drawing.width), coordinate(drawing.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 \
         {width} {height}\" role=\"img\">\n"
    );
    let _ = writeln!(out, "<title>{}</title>", xml::text(&drawing.title));
    if !drawing.metadata.is_empty() {
        let _ = writeln!(out, "<metadata>{}</metadata>", xml::text(&drawing.metadata));
    }
    let _ = writeln!(out, "<style>{}</style>", style_sheet());
    for item in &drawing.items {
        write_item(&mut out, item);
    }
    out.push_str("</svg>\n");
    out
}

fn write_item(out: &mut String, item: &Item) {
    let _ = match item {
        Item::Line(points, stroke) => {
            writeln!(
                out,
                "<path d=\"{}\" fill=\"none\" {}/>",
                path(&simplified(points, 0.12)),
                stroke_attributes(stroke)
            )
        }
        Item::Area(points, ink, opacity) => {
            writeln!(
                out,
                "<path d=\"{}Z\" class=\"{}\"{}/>",
                path(points),
                ink.class(),
                opacity_attribute("fill", *opacity)
            )
        }
        Item::Dot(centre, radius, ink, opacity) => writeln!(
            out,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" class=\"{}\"{}/>",
            coordinate(centre[0]),
            coordinate(centre[1]),
            coordinate(*radius),
            ink.class(),
            opacity_attribute("fill", *opacity)
        ),
        Item::Words(words) => write_words(out, words),
    };
}

fn write_words(out: &mut String, words: &Words) -> std::fmt::Result {
    let (x, y) = (coordinate(words.at[0]), coordinate(words.at[1]));
    let anchor = match words.anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let turn = if words.upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    let weight = if words.bold { " font-weight=\"600\"" } else { "" };
    writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" class=\"{}\" font-size=\"{}\"{anchor}{turn}{weight}>{}</text>",
        words.ink.class(),
        coordinate(words.size),
        xml::text(&words.text)
    )
}

fn stroke_attributes(stroke: &Stroke) -> String {
    let dash = stroke.dash.map_or(String::new(), |[on, off]| {
        format!(" stroke-dasharray=\"{} {}\"", coordinate(on), coordinate(off))
    });
    let (class, width) = (stroke.ink.class(), coordinate(stroke.width));
    format!(
        "class=\"{class}-line\" stroke-width=\"{width}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\"{dash}{}",
        opacity_attribute("stroke", stroke.opacity)
    )
}

fn opacity_attribute(what: &str, opacity: f64) -> String {
    if opacity < 1.0 { format!(" {what}-opacity=\"{opacity:.2}\"") } else { String::new() }
}

fn path(points: &[Point]) -> String {
    let mut out = String::new();
    for (index, point) in points.iter().enumerate() {
        let command = if index == 0 { 'M' } else { 'L' };
        let _ = write!(out, "{command}{} {}", coordinate(point[0]), coordinate(point[1]));
    }
    out
}

/// A number with at most one decimal, without trailing or negative zero.
fn coordinate(value: f64) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

#[cfg(test)]
mod tests {
    use super::super::Ink;
    use super::*;

    #[test]
    fn a_line_and_a_text_become_a_path_and_a_text() {
        let mut drawing = Drawing::new(100.0, 50.0, "a < b");
        drawing.metadata = "{\"figure\":\"x\"}".to_string();
        drawing.line(
            &[[0.0, 0.0], [f64::NAN, 1.0], [10.0, -0.04], [20.25, 30.0]],
            Stroke::dashed(Ink::Arm(1), 1.5),
        );
        drawing.text([5.0, 6.0], "n & m", Ink::Text, Anchor::Middle);
        let svg = drawing.to_svg();
        assert!(svg.contains("<title>a &lt; b</title>"));
        assert!(svg.contains("<metadata>{\"figure\":\"x\"}</metadata>"));
        assert!(
            svg.contains("<path d=\"M10 0L20.2 30\" fill=\"none\" class=\"arm1-line\" stroke-width=\"1.5\""),
            "{svg}"
        );
        assert!(svg.contains("text-anchor=\"middle\">n &amp; m</text>"), "{svg}");
        assert_eq!(svg, drawing.to_svg());
    }
}
