//! Failure rate in each decile of every parameter: one small panel per parameter, one line per arm.

use super::View;
use crate::report::failures::{is_of_sets, sets};
use crate::report::figure::{Entry, Figure, legend};
use crate::report::plot::drawing::text_width;
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke, palette};
use crate::report::wording::shortened;
use crate::statistics::CONFIDENCE;
use crate::statistics::failure::Sets;
use crate::statistics::failure::deciles;

/// Panels per row.
const COLUMNS: usize = 4;
/// Size of a panel and the gaps to the right and below, in pixels.
const PANEL: [f64; 2] = [176.0, 108.0];
const GAP: [f64; 2] = [34.0, 44.0];

/// The figure, if an arm was evaluated on parameter sets that vary.
pub fn figure(view: &View) -> Option<Figure> {
    let stage = view.stage(|measured| is_of_sets(&measured.evaluation))?;
    let all: Vec<(String, Sets)> = view
        .groups
        .iter()
        .map(|group| (shortened(group.name, 40), sets(group, &stage)))
        .filter(|(_, sets)| sets.rows.len() >= deciles::PARTS && !sets.names.is_empty())
        .collect();
    let arms = &all[..all.len().min(palette::ARMS)];
    let names = &arms.first()?.1.names;
    let columns = names.len().min(COLUMNS);
    let rows = names.len().div_ceil(columns);
    let lines = legend_lines(arms);
    let top = 24.0 + 20.0 * lines.len() as f64 + 16.0;
    let grid = Area {
        left: 60.0,
        top,
        width: columns as f64 * (PANEL[0] + GAP[0]) - GAP[0],
        height: rows as f64 * (PANEL[1] + GAP[1]) - GAP[1],
    };
    let mut drawing = Drawing::new(grid.right() + 18.0, grid.bottom() + 44.0, "Failure rate by parameter");
    for (line, entries) in lines.iter().enumerate() {
        legend(&mut drawing, [60.0, 22.0 + 20.0 * line as f64], entries);
    }
    let highest = highest(arms);
    for (at, name) in names.iter().enumerate() {
        let area = grid.cell([columns, rows], [at % columns, at / columns], GAP);
        let lowest = at + columns >= names.len();
        let label = if at % columns == 0 { "failures (%)" } else { "" };
        let x = Axis::over("half ranges from nominal", [-1.0, 1.0], 2);
        let panel = Panel {
            area,
            x: if lowest { x } else { x.without_words() },
            y: Axis::from_zero(label, [highest], 3),
        };
        panel.frame(&mut drawing, &name.replace('_', " "));
        for (arm, (_, sets)) in arms.iter().enumerate() {
            draw(&mut drawing, &panel, sets, name, Ink::Arm(arm));
        }
    }
    Some(Figure {
        id: view.id(),
        title: "Failure rate by parameter".to_owned(),
        caption: caption(&stage, arms, all.len()),
        drawing,
        sources: view.sources(&stage),
    })
}

fn caption(stage: &str, arms: &[(String, Sets)], count: usize) -> String {
    let n = |(name, sets): &(String, Sets)| {
        let [failed, tried] = sets.counts();
        format!("{name}: n = {tried} tries of {} sets, {failed} failures", sets.rows.len())
    };
    let n: Vec<String> = arms.iter().map(n).collect();
    let rest = if count > arms.len() {
        format!(" {} more arms are not drawn.", count - arms.len())
    } else {
        String::new()
    };
    format!(
        "Share of the episodes of `{stage}` that end before their time limit, in each tenth of a parameter's \
         values, with Wilson's 95 % intervals. {}.{rest}",
        n.join("; ")
    )
}

/// The names of the arms in as many lines as they need.
fn legend_lines(arms: &[(String, Sets)]) -> Vec<Vec<Entry>> {
    let most = COLUMNS as f64 * (PANEL[0] + GAP[0]);
    let (mut lines, mut reached): (Vec<Vec<Entry>>, f64) = (Vec::new(), f64::INFINITY);
    for (arm, (name, _)) in arms.iter().enumerate() {
        let width = 50.0 + text_width(name, 12.0);
        if reached + width > most {
            lines.push(Vec::new());
            reached = 0.0;
        }
        reached += width;
        let entry = Entry { stroke: Stroke::solid(Ink::Arm(arm), 1.8), text: name.clone() };
        lines
            .iter_mut()
            .next_back()
            .into_iter()
            .for_each(|line| line.push(Entry { text: entry.text.clone(), ..entry }));
    }
    lines
}

fn highest(arms: &[(String, Sets)]) -> f64 {
    let of = |sets: &Sets| -> f64 {
        let all = (0..sets.names.len()).flat_map(|at| deciles::of(sets, at, CONFIDENCE));
        all.map(|decile| decile.rate).fold(0.0, f64::max)
    };
    100.0 * arms.iter().map(|(_, sets)| of(sets)).fold(0.01, f64::max)
}

fn draw(drawing: &mut Drawing, panel: &Panel, sets: &Sets, name: &String, ink: Ink) {
    let Some(parameter) = sets.names.iter().position(|own| own == name) else { return };
    let deciles = deciles::of(sets, parameter, CONFIDENCE);
    let band: Vec<(f64, f64, f64)> =
        deciles.iter().map(|d| (d.place, 100.0 * d.interval.low, 100.0 * d.interval.high)).collect();
    panel.band(drawing, &band, ink, 0.15);
    let line: Vec<(f64, f64)> = deciles.iter().map(|d| (d.place, 100.0 * d.rate)).collect();
    panel.line(drawing, &line, Stroke::solid(ink, 1.6));
    line.iter().for_each(|(x, y)| drawing.dot(panel.place(*x, *y), 2.2, ink, 1.0));
}
