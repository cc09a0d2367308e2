//! A time-lapse of stick figures from the side, with the reference motion at the same phases.

use super::skeleton::{Posture, Skeleton, crown, skeleton};
use super::{Entry, Figure, legend, window};
use crate::kinds::motion::{Frame, Motion};
use crate::outcome::Trace;
use crate::report::model::{Arm, ReportInput};
use crate::report::plot::{Anchor, Drawing, Ink, Point, Stroke, axis::written};
use crate::report::source::Source;
use crate::report::wording::labels;
use crate::robot::Robot;

/// Prefix of the figures' names.
pub const ID: &str = "time_lapse";

/// Number of stick figures.
const POSES: usize = 12;
/// Vertical force in N above which a foot counts as in contact.
const CONTACT: f64 = 10.0;
/// Distance between two figures in pixels.
const SPACING: f64 = 72.0;

/// The figure for an arm's first evaluation with a trace.
pub fn figure(input: &ReportInput, arm: usize) -> Option<Figure> {
    let name = &labels(&input.arms)[arm];
    let arm = &input.arms[arm];
    let robot = arm.robot.as_ref()?;
    let measured = arm.evaluations.iter().find(|measured| is_complete(&measured.evaluation.trace, robot))?;
    let trace = &measured.evaluation.trace;
    let rows = window::cycles(trace, 2, 1.6);
    let (first, last) = (rows.start, rows.end - 1);
    let mut drawing = Drawing::new(912.0, 318.0, format!("Time-lapse of {}", arm.name));
    let strip = Strip { robot, trace, scale: 150.0 / tallest(robot), ground: 226.0 };
    drawing.line(&[[14.0, strip.ground], [898.0, strip.ground]], Stroke::solid(Ink::Muted, 1.0));
    for pose in 0..POSES {
        let row = first + (last - first) * pose / (POSES - 1);
        let centre = 24.0 + SPACING * (pose as f64 + 0.5);
        strip.pose(&mut drawing, centre, row, first, arm.motion.as_ref());
    }
    key(&mut drawing, arm.motion.is_some());
    let seconds = trace.time[last] - trace.time[first];
    Some(Figure {
        id: format!("{ID}_{}", arm.name),
        title: format!("Time-lapse: {name}"),
        caption: caption(arm, &measured.evaluation.engine, seconds),
        drawing,
        sources: vec![Source { arm: arm.name.clone(), stage: measured.stage.clone() }],
    })
}

/// Whether a trace has the rows that a stick figure requires.
fn is_complete(trace: &Trace, robot: &Robot) -> bool {
    let rows = trace.time.len();
    rows > 1
        && trace.base_position.len() == rows
        && trace.base_orientation.len() == rows
        && trace.position.len() == rows
        && trace.foot_force.len() == rows
        && trace.position.iter().all(|position| position.len() == robot.joints())
}

/// Crown height of the standing robot in m.
fn tallest(robot: &Robot) -> f64 {
    robot.standing_height + crown(robot)
}

fn caption(arm: &Arm, engine: &str, seconds: f64) -> String {
    let reference = if arm.motion.is_some() { "; thin: the reference motion at the same phase" } else { "" };
    format!(
        "{POSES} moments, evenly spaced over {} s of one episode (n = 1) in {engine}, seen from the right \
         side and set beside each other; under each figure the time and the distance travelled since the \
         first{reference}. Marks above: foot on the ground (more than {CONTACT} N).",
        written(seconds, 2)
    )
}

fn key(drawing: &mut Drawing, reference: bool) {
    let entry = |ink, width, text: &str| Entry { stroke: Stroke::solid(ink, width), text: text.to_string() };
    let mut entries = vec![entry(Ink::Left, 2.6, "left leg"), entry(Ink::Right, 2.6, "right leg")];
    if reference {
        entries.push(entry(Ink::Reference, 1.0, "reference motion"));
    }
    legend(drawing, [24.0, 300.0], &entries);
}

struct Strip<'a> {
    robot: &'a Robot,
    trace: &'a Trace,
    /// Pixels per metre.
    scale: f64,
    /// Height of the ground in pixels.
    ground: f64,
}

impl Strip<'_> {
    fn pose(&self, drawing: &mut Drawing, centre: f64, row: usize, first: usize, motion: Option<&Motion>) {
        let base = self.trace.base_position[row];
        if let Some(motion) = motion {
            let mut frame = Frame::default();
            motion.at(self.trace.phase.get(row).copied().unwrap_or(0.0), &mut frame);
            let posture = Posture {
                base_position: [base[0], 0.0, frame.base_height],
                base_orientation: frame.base_orientation,
                position: &frame.position,
            };
            if frame.position.len() == self.robot.joints() {
                self.figure(drawing, &skeleton(self.robot, &posture), (centre, base[0]), true);
            }
        }
        let posture = Posture {
            base_position: base,
            base_orientation: self.trace.base_orientation[row],
            position: &self.trace.position[row],
        };
        self.figure(drawing, &skeleton(self.robot, &posture), (centre, base[0]), false);
        self.remarks(drawing, centre, row, first);
    }

    /// Draws a stick figure such that the world position `x` in m is at `centre` in pixels.
    fn figure(&self, drawing: &mut Drawing, skeleton: &Skeleton, (centre, x): (f64, f64), reference: bool) {
        let place =
            |point: &[f64; 2]| [centre + self.scale * (point[0] - x), self.ground - self.scale * point[1]];
        let polyline = |points: &[[f64; 2]]| -> Vec<Point> { points.iter().map(place).collect() };
        let stroke = |ink, width| {
            if reference { Stroke::solid(Ink::Reference, 1.0).faint(0.8) } else { Stroke::solid(ink, width) }
        };
        drawing.line(&polyline(&skeleton.legs[0]), stroke(Ink::Left, 2.6));
        let trunk = polyline(&skeleton.trunk);
        drawing.line(&trunk, stroke(Ink::Text, 3.0));
        if !reference && let Some(crown) = trunk.last() {
            drawing.dot([crown[0], crown[1] - 7.0], 7.0, Ink::Text, 1.0);
        }
        drawing.line(&polyline(&skeleton.legs[1]), stroke(Ink::Right, 2.6));
    }

    /// Time, distance and contacts of a pose.
    fn remarks(&self, drawing: &mut Drawing, centre: f64, row: usize, first: usize) {
        let time = self.trace.time[row] - self.trace.time[first];
        let distance = self.trace.base_position[row][0] - self.trace.base_position[first][0];
        let (time, distance) = (format!("{} s", written(time, 2)), format!("{} m", written(distance, 2)));
        drawing.text([centre, self.ground + 20.0], time, Ink::Text, Anchor::Middle).size = 11.0;
        drawing.text([centre, self.ground + 35.0], distance, Ink::Muted, Anchor::Middle).size = 11.0;
        let contact = self.trace.foot_force[row].map(|force| force[2] > CONTACT);
        for (on, ink, offset) in [(contact[0], Ink::Left, -8.0), (contact[1], Ink::Right, 8.0)] {
            if on {
                drawing.rectangle([centre + offset - 6.0, 20.0], [centre + offset + 6.0, 27.0], ink, 1.0);
            }
        }
        if contact == [false, false] {
            drawing.text([centre, 28.0], "flight", Ink::Muted, Anchor::Middle).size = 11.0;
        }
    }
}
