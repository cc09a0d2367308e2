//! What makes parameter sets fail, for every arm: the direction of failure, and the coefficients of a
//! logistic regression on the parameters and their squares, with intervals.

use super::View;
use crate::report::failures::{analysis, is_of_sets};
use crate::report::figure::Figure;
use crate::report::plot::drawing::text_width;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::wording::shortened;
use crate::statistics::failure::{Analysis, Ranged, Sets};

/// Heights of a parameter's line, above a panel and below it, in pixels.
const LINE: f64 = 20.0;
const HEAD: f64 = 30.0;
const BELOW: f64 = 50.0;
/// Widths of a panel and of the gap to the next one.
const WIDTH: f64 = 220.0;
const GAP: f64 = 24.0;

/// A column of the figure: its heading, its axis and the numbers that it draws.
type Column = (&'static str, &'static str, fn(&Analysis) -> &[Ranged]);

const COLUMNS: [Column; 3] = [
    ("direction of failure", "entry of the unit vector", |found| &found.loadings),
    ("logistic regression", "log odds by one deviation", |found| &found.linear),
    ("its squares", "log odds by one deviation of the square", |found| &found.quadratic),
];

/// An arm with enough failures.
struct Found {
    name: String,
    sets: Sets,
    analysis: Analysis,
}

/// The figure, if an arm was evaluated over parameter sets and has enough failures.
pub fn figure(view: &View) -> Option<Figure> {
    let stage = view.stage(|measured| is_of_sets(&measured.evaluation))?;
    let found: Vec<Found> = view
        .groups
        .iter()
        .filter_map(|group| {
            analysis(group, &stage).map(|(sets, analysis)| Found {
                name: group.name.to_owned(),
                sets,
                analysis,
            })
        })
        .collect();
    let names = &found.first()?.sets.names;
    let left = 20.0 + names.iter().map(|name| text_width(&spaced(name), 12.0)).fold(0.0, f64::max);
    let height = LINE * names.len() as f64;
    let row = HEAD + height + BELOW;
    let width = left + COLUMNS.len() as f64 * (WIDTH + GAP);
    let mut drawing = Drawing::new(width, 26.0 + row * found.len() as f64, "What makes parameter sets fail");
    for (column, (head, _, _)) in COLUMNS.iter().enumerate() {
        let centre = left + (WIDTH + GAP) * column as f64 + 0.5 * WIDTH;
        drawing.text([centre, 18.0], *head, Ink::Muted, Anchor::Middle);
    }
    for (column, (_, label, of)) in COLUMNS.iter().enumerate() {
        let ends = found.iter().flat_map(|found| of(&found.analysis)).flat_map(reach);
        let reach = ends.map(f64::abs).fold(0.1, f64::max) * 1.05;
        for (down, arm) in found.iter().enumerate() {
            let top = 26.0 + row * down as f64 + HEAD;
            let area = Area { left: left + (WIDTH + GAP) * column as f64, top, width: WIDTH, height };
            let panel = Panel {
                area,
                x: Axis::over(*label, [-reach, reach], 4),
                y: Axis { label: String::new(), range: [0.0, names.len() as f64], ticks: Vec::new() },
            };
            panel.frame(&mut drawing, &if column == 0 { shortened(&arm.name, 60) } else { String::new() });
            let zero = panel.place(0.0, 0.0)[0];
            drawing.line(&[[zero, area.top], [zero, area.bottom()]], Stroke::solid(Ink::Muted, 1.0));
            let names = if column == 0 { Some(arm.sets.names.as_slice()) } else { None };
            lines(&mut drawing, &panel, of(&arm.analysis), names);
        }
    }
    Some(Figure {
        id: view.id(),
        title: "What makes parameter sets fail".to_owned(),
        caption: caption(&stage, &found),
        drawing,
        sources: view.sources(&stage),
    })
}

fn caption(stage: &str, found: &[Found]) -> String {
    let n = |found: &Found| {
        let [failed, tried] = found.sets.counts();
        let ridge = if found.analysis.ridge.is_some() { ", regression held by a ridge penalty" } else { "" };
        format!(
            "{}: n = {failed} failures in {tried} tries of {} sets{ridge}",
            found.name,
            found.sets.rows.len()
        )
    };
    let n: Vec<String> = found.iter().map(n).collect();
    format!(
        "`{stage}`. Left: the first right-singular vector of the failed sets' distances from the nominal \
         set, in units of half the range, not centred, pointing to where the \
         failed sets lie. Middle and right: coefficients of one logistic regression of failure on the \
         standardised parameters and their standardised squares; a square that \
         counts means failure at both extremes. Bars: 95 % intervals from resampling sets; a dot is filled \
         where its interval leaves out zero. {}.",
        n.join("; ")
    )
}

fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

fn reach(number: &Ranged) -> impl Iterator<Item = f64> {
    [Some(number.value), number.interval.map(|ends| ends.low), number.interval.map(|ends| ends.high)]
        .into_iter()
        .flatten()
}

/// A dot with its interval for each parameter, filled if the interval excludes zero. Names are to the left of
/// the first column.
fn lines(drawing: &mut Drawing, panel: &Panel, numbers: &[Ranged], names: Option<&[String]>) {
    for (line, number) in numbers.iter().enumerate() {
        let y = panel.area.top + LINE * (line as f64 + 0.5);
        if let Some(name) = names.and_then(|names| names.get(line)) {
            drawing.text([panel.area.left - 10.0, y + 4.0], spaced(name), Ink::Text, Anchor::End);
        }
        let across = |value: f64| panel.place(value, 0.0)[0];
        let apart = number.interval.is_some_and(|ends| !ends.contains(0.0));
        let ink = match (names, apart) {
            (_, false) => Ink::Muted,
            (Some(_), true) => Ink::Text,
            (None, true) => Ink::Arm(0),
        };
        if let Some(ends) = number.interval {
            drawing.line(&[[across(ends.low), y], [across(ends.high), y]], Stroke::solid(ink, 2.0));
        }
        match apart {
            true => drawing.dot([across(number.value), y], 4.0, ink, 1.0),
            false => drawing.ring([across(number.value), y], 3.5, Stroke::solid(ink, 1.6)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::drawing::Item;
    use crate::statistics::Interval;

    #[test]
    fn a_dot_whose_interval_holds_zero_is_hollow_in_every_column() {
        let number =
            |low: f64| Ranged { value: low + 0.5, interval: Some(Interval { low, high: low + 1.0 }) };
        let names = ["delay", "mass"].map(str::to_owned);
        for names in [Some(names.as_slice()), None] {
            let mut drawing = Drawing::new(100.0, 100.0, "");
            let area = Area { left: 0.0, top: 0.0, width: 100.0, height: 2.0 * LINE };
            let y = Axis { label: String::new(), range: [0.0, 2.0], ticks: Vec::new() };
            let panel = Panel { area, x: Axis::over("", [-2.0, 2.0], 4), y };
            lines(&mut drawing, &panel, &[number(0.2), number(-0.3)], names);
            let filled = drawing.items.iter().filter(|item| matches!(item, Item::Dot(..))).count();
            assert_eq!(filled, 1);
        }
    }
}
