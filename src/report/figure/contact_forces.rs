//! Vertical foot forces with the contact schedule: one row per arm, one column per engine.

use super::{Entry, Figure, legend, window};
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::source::sources;
use crate::report::wording::labels;
use crate::robot::GRAVITY;

/// The figure's name.
pub const ID: &str = "contact_forces";

/// The figure, if at least one evaluation has a trace of foot forces.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let engines = engines(input);
    if engines.is_empty() {
        return None;
    }
    let (columns, rows) = (engines.len(), input.arms.len());
    let height = 70.0 + 200.0 * rows as f64;
    let mut drawing = Drawing::new(880.0, height, "Vertical foot forces");
    let entries = [("left foot", Ink::Left), ("right foot", Ink::Right)]
        .map(|(text, ink)| Entry { stroke: Stroke::solid(ink, 1.8), text: text.to_string() });
    legend(&mut drawing, [64.0, 22.0], &entries);
    drawing.text([290.0, 22.0], "bars: scheduled contact; dashed: body weight", Ink::Muted, Anchor::Start);
    let grid = Area { left: 64.0, top: 62.0, width: 796.0, height: height - 112.0 };
    let top = highest(input.arms.iter().flat_map(|arm| &arm.evaluations));
    let names = labels(&input.arms);
    for (row, arm) in input.arms.iter().enumerate() {
        for (column, engine) in engines.iter().enumerate() {
            let area = grid.cell([columns, rows], [column, row], [64.0, 72.0]);
            let title = format!("{} in {engine}", names[row]);
            panel(&mut drawing, area, arm, measured(arm, engine), title, top, column == 0);
        }
    }
    Some(Figure {
        id: ID.to_string(),
        title: "Vertical foot forces".to_string(),
        caption: format!(
            "Vertical force of the ground on each foot over two cycles from the middle of one episode per \
             panel (n = 1 each), from the start of a cycle (the last 1.6 s of an episode that ended sooner), \
             in {}.",
            engines.join(" and ")
        ),
        drawing,
        sources: sources(input, |arm| {
            let stages = engines.iter().filter_map(|engine| measured(arm, engine));
            stages.map(|measured| measured.stage.clone()).collect()
        }),
    })
}

/// The engines with traces, in the order of the arms' evaluations; at most three.
fn engines(input: &ReportInput) -> Vec<String> {
    let mut engines: Vec<String> = Vec::new();
    for measured in input.arms.iter().flat_map(|arm| &arm.evaluations) {
        let engine = &measured.evaluation.engine;
        if has_forces(measured) && !engines.contains(engine) && engines.len() < 3 {
            engines.push(engine.clone());
        }
    }
    engines
}

/// Whether an evaluation recorded the foot forces and contact schedule of an episode.
pub(super) fn has_forces(measured: &Measured) -> bool {
    let trace = &measured.evaluation.trace;
    trace.time.len() > 1
        && trace.foot_force.len() == trace.time.len()
        && trace.schedule.len() == trace.time.len()
}

fn measured<'a>(arm: &'a Arm, engine: &str) -> Option<&'a Measured> {
    arm.evaluations.iter().find(|measured| measured.evaluation.engine == engine && has_forces(measured))
}

/// The largest vertical force visible in any of these evaluations, in kN.
pub(super) fn highest<'a>(shown: impl Iterator<Item = &'a Measured>) -> f64 {
    shown.filter(|measured| has_forces(measured)).map(peak).fold(0.0, f64::max) / 1000.0
}

/// The largest vertical force in the visible window, in N.
pub(super) fn peak(measured: &Measured) -> f64 {
    let trace = &measured.evaluation.trace;
    let forces = window::cycles(trace, 2, 1.6).flat_map(|row| trace.foot_force[row].map(|force| force[2]));
    forces.fold(0.0, f64::max)
}

/// The forces of one evaluation with the contact schedule; `top` is the largest force of any panel in kN.
pub(super) fn panel(
    drawing: &mut Drawing,
    area: Area,
    arm: &Arm,
    measured: Option<&Measured>,
    title: String,
    top: f64,
    first: bool,
) {
    let rows = measured.map_or(0..0, |measured| window::cycles(&measured.evaluation.trace, 2, 1.6));
    let times: Vec<f64> = measured
        .map(|measured| rows.clone().map(|row| measured.evaluation.trace.time[row]).collect())
        .unwrap_or_default();
    let start = times.first().copied().unwrap_or(0.0);
    let end = times.last().copied().unwrap_or(1.0) - start;
    let panel = Panel {
        area,
        x: Axis::over("time since the start of a cycle (s)", [0.0, end.max(1e-6)], 6),
        y: Axis::from_zero(if first { "force (kN)" } else { "" }, [1.08 * top], 4),
    };
    panel.frame(drawing, &title);
    let Some(measured) = measured else {
        let centre = [area.left + 0.5 * area.width, area.top + 0.5 * area.height];
        drawing.text(centre, "no trace", Ink::Muted, Anchor::Middle);
        return;
    };
    let trace = &measured.evaluation.trace;
    if let Some(robot) = &arm.robot {
        panel.level(drawing, robot.total_mass() * GRAVITY / 1000.0, Stroke::dashed(Ink::Reference, 1.2));
    }
    for (foot, ink) in [Ink::Left, Ink::Right].into_iter().enumerate() {
        let force = |row: usize| (trace.time[row] - start, trace.foot_force[row][foot][2] / 1000.0);
        let scheduled: Vec<(f64, bool)> =
            rows.clone().map(|row| (trace.time[row] - start, trace.schedule[row][foot])).collect();
        let y = area.top + 1.0 + 6.0 * foot as f64;
        for [from, to] in stretches(&scheduled) {
            let (left, right) = (panel.place(from, 0.0)[0], panel.place(to, 0.0)[0]);
            drawing.rectangle([left, y], [right, y + 4.0], ink, 0.55);
        }
        panel.line(drawing, &rows.clone().map(force).collect::<Vec<_>>(), Stroke::solid(ink, 1.5));
    }
}

/// The time intervals in which the flag is set.
fn stretches(flags: &[(f64, bool)]) -> Vec<[f64; 2]> {
    let runs = flags.chunk_by(|a, b| a.1 == b.1).filter(|run| run[0].1);
    let end = |run: &[(f64, bool)]| {
        let last = run[run.len() - 1].0;
        flags.iter().map(|(time, _)| *time).find(|time| *time > last).unwrap_or(last)
    };
    runs.map(|run| [run[0].0, end(run)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_ends_where_the_flag_falls() {
        let flags = [(0.0, true), (0.1, true), (0.2, false), (0.3, true)];
        assert_eq!(stretches(&flags), vec![[0.0, 0.2], [0.3, 0.3]]);
    }
}
