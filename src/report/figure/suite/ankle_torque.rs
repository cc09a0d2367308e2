//! Torque commanded to the ankle pitch joints in two evaluations of one policy, such as without and with a
//! box, and the moments at which a foot passes over the box.

use super::{View, evaluated};
use crate::outcome::{Evaluation, Trace};
use crate::report::figure::{Entry, Figure, legend};
use crate::report::group::Group;
use crate::report::model::{Arm, Measured};
use crate::report::plot::axis::written;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::source::Source;
use crate::report::wording::shortened;
use crate::robot::Robot;
use crate::robot::legs::Leg;

/// Most arms that are drawn.
const ARMS: usize = 4;
/// Time shown before and after the event, in s; without an event, the window is in the middle of the trace.
const WINDOW: [f64; 2] = [3.0, 5.0];
/// Colours of the two evaluations. Arm colours are free for this, as each panel shows a single arm.
const INKS: [Ink; 2] = [Ink::Arm(0), Ink::Arm(1)];

/// A policy with both evaluations.
struct Twice<'a> {
    arm: &'a Arm,
    robot: &'a Robot,
    name: String,
    sides: [&'a Measured; 2],
    /// The ankle pitch joints of the left and the right leg.
    ankles: [usize; 2],
}

/// The figure, if a run has traces in two evaluations, one of them with an obstacle.
pub fn figure(view: &View) -> Option<Figure> {
    let twice: Vec<Twice> = view.groups.iter().filter_map(|group| of_group(view, group)).collect();
    let shown = &twice[..twice.len().min(ARMS)];
    let first = shown.first()?;
    let rows = shown.len();
    let height = 74.0 + 190.0 * rows as f64;
    let mut drawing = Drawing::new(880.0, height, "Commanded ankle pitch torque");
    let entries: Vec<Entry> = (0..2)
        .map(|side| Entry { stroke: Stroke::solid(INKS[side], 1.8), text: first.sides[side].stage.clone() })
        .collect();
    legend(&mut drawing, [64.0, 22.0], &entries);
    let note = "vertical: a foot comes over the box; dashed: effort limit";
    drawing.text([860.0, 22.0], note, Ink::Muted, Anchor::End).size = 11.0;
    let grid = Area { left: 64.0, top: 62.0, width: 796.0, height: height - 112.0 };
    for (row, twice) in shown.iter().enumerate() {
        for leg in [0, 1] {
            let area = grid.cell([2, rows], [leg, row], [64.0, 62.0]);
            draw(&mut drawing, area, twice, leg, row + 1 == rows);
        }
    }
    let source = |twice: &Twice| {
        twice.sides.map(|side| Source { arm: twice.arm.name.clone(), stage: side.stage.clone() })
    };
    Some(Figure {
        id: view.id(),
        title: "Commanded ankle pitch torque".to_string(),
        caption: caption(shown, twice.len()),
        drawing,
        sources: shown.iter().flat_map(source).collect(),
    })
}

fn caption(shown: &[Twice], count: usize) -> String {
    let peaks = |twice: &Twice| {
        let [first, second] = twice.sides.map(|side| written(twice.peak(&side.evaluation.trace), 0));
        format!("{}: {first} and {second} N m", twice.name)
    };
    let peaks: Vec<String> = shown.iter().map(peaks).collect();
    let rest = count - shown.len();
    let rest = if rest > 0 { format!(" {rest} more arms are not drawn.") } else { String::new() };
    let [first, second] = shown[0].sides;
    format!(
        "Torque commanded to the ankle pitch joints in one episode of `{}` and one of `{}` (n = 1 each) of \
         the first seed of an arm, in {}. \
         Largest absolute torque of both ankles in the window shown, in this order: {}.{rest}",
        first.stage,
        second.stage,
        second.evaluation.engine,
        peaks.join("; ")
    )
}

impl Twice<'_> {
    /// When the foot of this leg first reaches the obstacle, in each evaluation.
    fn events(&self, leg: usize) -> [Option<f64>; 2] {
        self.sides.map(|side| arrival(&side.evaluation, leg, self.robot))
    }

    /// First and last time shown.
    fn window(&self) -> [f64; 2] {
        let event = [0, 1].into_iter().flat_map(|leg| self.events(leg)).flatten().reduce(f64::min);
        let last = |side: &Measured| side.evaluation.trace.time.last().copied().unwrap_or(0.0);
        let end = self.sides.map(last).into_iter().fold(0.0, f64::max);
        let centre = event.unwrap_or(0.5 * end);
        [(centre - WINDOW[0]).max(0.0), (centre + WINDOW[1]).min(end)]
    }

    fn curve(&self, trace: &Trace, leg: usize) -> Vec<(f64, f64)> {
        let [from, to] = self.window();
        let rows = trace.time.iter().zip(&trace.torque).filter(|(time, _)| (from..=to).contains(time));
        rows.map(|(time, torque)| (*time, torque[self.ankles[leg]])).collect()
    }

    /// The largest absolute torque of both ankles in the window.
    fn peak(&self, trace: &Trace) -> f64 {
        let both = [0, 1].into_iter().flat_map(|leg| self.curve(trace, leg));
        both.map(|(_, torque)| torque.abs()).fold(0.0, f64::max)
    }
}

/// When the front end of a sole first passes the obstacle's front edge, in s.
fn arrival(evaluation: &Evaluation, leg: usize, robot: &Robot) -> Option<f64> {
    let ([front, _], half) = (evaluation.obstacle?, robot.feet[leg].half_extents.x);
    let trace = &evaluation.trace;
    let over = trace.foot_position.iter().position(|feet| feet[leg][0] + half >= front)?;
    trace.time.get(over).copied()
}

/// The first run of an arm with both evaluations: the named ones, or the first with an obstacle and the first
/// without one in the same engine.
fn of_group<'a>(view: &View, group: &Group<'a>) -> Option<Twice<'a>> {
    group.runs.iter().find_map(|run| {
        let robot = run.robot.as_ref()?;
        let ankles = [0, 1].map(|side| Leg::pitches(robot, side).map(|[_, _, (ankle, _)]| ankle));
        let [Some(left), Some(right)] = ankles else { return None };
        let is_complete = |measured: &&Measured| {
            let trace = &measured.evaluation.trace;
            let joints = |torque: &Vec<f64>| torque.len() == robot.joints();
            trace.time.len() > 1 && trace.torque.len() == trace.time.len() && trace.torque.iter().all(joints)
        };
        let sides = match view.wanted.about.as_slice() {
            [first, second] => [evaluated(run, first)?, evaluated(run, second)?],
            _ => {
                let traced = || run.evaluations.iter().filter(is_complete);
                let over = traced().find(|measured| measured.evaluation.obstacle.is_some())?;
                let alike = |measured: &&Measured| {
                    measured.evaluation.obstacle.is_none()
                        && measured.evaluation.engine == over.evaluation.engine
                };
                [traced().find(alike)?, over]
            }
        };
        let name = shortened(group.name, 40);
        sides.iter().all(is_complete).then_some(Twice { arm: run, robot, name, sides, ankles: [left, right] })
    })
}

fn draw(drawing: &mut Drawing, area: Area, twice: &Twice, leg: usize, lowest: bool) {
    let curves = twice.sides.map(|side| twice.curve(&side.evaluation.trace, leg));
    let both = [0, 1].map(|leg| twice.sides.map(|side| twice.curve(&side.evaluation.trace, leg)));
    let values = || both.iter().flatten().flatten().map(|(_, torque)| *torque);
    let limit = twice.robot.links[twice.ankles[leg]].joint.effort_limit;
    let reached = values().any(|torque| torque.abs() > 0.8 * limit);
    let levels: Vec<f64> = if reached { vec![limit, -limit] } else { Vec::new() };
    let panel = Panel {
        area,
        x: Axis::over(if lowest { "time (s)" } else { "" }, twice.window(), 8),
        y: Axis::from_zero(if leg == 0 { "torque (N m)" } else { "" }, values().chain(levels.clone()), 4),
    };
    panel.frame(drawing, &format!("{}, {} ankle", twice.name, ["left", "right"][leg]));
    panel.level(drawing, 0.0, Stroke::solid(Ink::Muted, 0.8));
    levels.iter().for_each(|level| panel.level(drawing, *level, Stroke::dashed(Ink::Reference, 1.2)));
    for event in twice.events(leg).into_iter().flatten() {
        let x = panel.place(event, 0.0)[0];
        drawing.line(&[[x, area.top], [x, area.bottom()]], Stroke::solid(Ink::Reference, 1.6));
    }
    for (side, curve) in curves.iter().enumerate() {
        panel.line(drawing, curve, Stroke::solid(INKS[side], if side == 0 { 2.2 } else { 1.2 }));
    }
}
