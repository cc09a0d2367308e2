//! Torques of hip pitch, knee and ankle pitch of both legs, all arms over each other.

use super::{Entry, Figure, legend, window};
use crate::outcome::Trace;
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::source::sources;
use crate::report::wording::labels;

/// The figure's name.
pub const ID: &str = "torques";

/// The joints shown: name and place within a leg (yaw, roll, pitch, knee, ankle pitch, ankle roll).
const JOINTS: [(&str, usize); 3] = [("hip pitch", 2), ("knee", 3), ("ankle pitch", 4)];
/// Joints of a leg.
const LEG: usize = 6;

/// The figure, when at least one arm has a trace of twelve joint torques.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let traces: Vec<Option<&Measured>> = input.arms.iter().map(measured).collect();
    traces.iter().flatten().next()?;
    let mut drawing = Drawing::new(880.0, 650.0, "Joint torques");
    let names = labels(&input.arms);
    let present = (0..input.arms.len()).filter(|arm| traces[*arm].is_some());
    let entries: Vec<Entry> =
        present.map(|arm| Entry { stroke: Stroke::solid(Ink::Arm(arm), 1.8), text: names[arm].clone() }).collect();
    legend(&mut drawing, [64.0, 22.0], &entries);
    let grid = Area { left: 64.0, top: 64.0, width: 796.0, height: 536.0 };
    for (row, joint) in JOINTS.iter().enumerate() {
        let curves: Vec<[Vec<(f64, f64)>; 2]> =
            traces.iter().map(|measured| [0, 1].map(|leg| curve(*measured, leg * LEG + joint.1))).collect();
        for leg in [0, 1] {
            let area = grid.cell([2, 3], [leg, row], [72.0, 62.0]);
            panel(&mut drawing, area, &curves, (leg, joint, row + 1 == JOINTS.len()), limit(input, leg, joint.1));
        }
    }
    let engine = traces.iter().flatten().next().map_or("", |measured| measured.evaluation.engine.as_str());
    Some(Figure {
        id: ID.to_string(),
        title: "Joint torques".to_string(),
        caption: format!(
            "Torque commanded to the joints over two cycles from the middle of one episode per arm (n = 1 each) in {engine}, from the start of a cycle (the last 1.6 s of an episode that ended sooner). Dashed: effort limit, where it is within reach."
        ),
        drawing,
        sources: sources(input, |arm| measured(arm).map(|measured| measured.stage.clone()).into_iter().collect()),
    })
}

/// The first evaluation of an arm with a trace of torques of two six-joint legs.
fn measured(arm: &Arm) -> Option<&Measured> {
    let complete = |trace: &Trace| {
        trace.time.len() > 1
            && trace.torque.len() == trace.time.len()
            && trace.torque.iter().all(|torque| torque.len() == 2 * LEG)
    };
    arm.evaluations.iter().find(|measured| complete(&measured.evaluation.trace))
}

fn curve(measured: Option<&Measured>, joint: usize) -> Vec<(f64, f64)> {
    let Some(measured) = measured else { return Vec::new() };
    let trace = &measured.evaluation.trace;
    let rows = window::cycles(trace, 2, 1.6);
    let start = trace.time[rows.start];
    rows.map(|row| (trace.time[row] - start, trace.torque[row][joint])).collect()
}

/// The effort limit of a joint of the first arm's robot.
fn limit(input: &ReportInput, leg: usize, joint: usize) -> Option<f64> {
    let robot = input.arms.iter().find_map(|arm| arm.robot.as_ref())?;
    robot.links.get(leg * LEG + joint).map(|link| link.joint.effort_limit)
}

fn panel(
    drawing: &mut Drawing,
    area: Area,
    curves: &[[Vec<(f64, f64)>; 2]],
    (leg, joint, last): (usize, &(&str, usize), bool),
    limit: Option<f64>,
) {
    let all = || curves.iter().flatten().flatten();
    let largest = all().map(|(_, torque)| torque.abs()).fold(0.0, f64::max);
    let limit = limit.filter(|limit| largest > 0.5 * limit);
    let limits = limit.iter().flat_map(|limit| [*limit, -limit]);
    let end = all().map(|(time, _)| *time).fold(0.0, f64::max);
    let x_label = if last { "time since the start of a cycle (s)" } else { "" };
    let panel = Panel {
        area,
        x: Axis::over(x_label, [0.0, end.max(1e-6)], 6),
        y: Axis::from_zero(if leg == 0 { "torque (N m)" } else { "" }, all().map(|(_, y)| *y).chain(limits), 4),
    };
    let title = format!("{} {}", ["left", "right"][leg], joint.0);
    panel.frame(drawing, &title);
    panel.level(drawing, 0.0, Stroke::solid(Ink::Muted, 0.8));
    for level in limit.iter().flat_map(|limit| [*limit, -limit]) {
        panel.level(drawing, level, Stroke::dashed(Ink::Reference, 1.2));
    }
    // The first arm is drawn last, on top.
    for (arm, curve) in curves.iter().enumerate().rev() {
        panel.line(drawing, &curve[leg], Stroke::solid(Ink::Arm(arm), 1.3).faint(0.9));
    }
}
