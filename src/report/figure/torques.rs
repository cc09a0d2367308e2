//! Torques of hip pitch, knee and ankle pitch of both legs, with all arms overlaid.

use super::{Entry, Figure, legend, window};
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::source::sources;
use crate::report::wording::labels;
use crate::robot::Robot;
use crate::robot::legs::Leg;

/// The figure's name.
pub const ID: &str = "torques";

/// The joints shown, in the order of [`Leg::pitches`].
const JOINTS: [&str; 3] = ["hip pitch", "knee", "ankle pitch"];

/// An arm with a trace of joint torques.
struct Traced<'a> {
    /// Its index in the report.
    arm: usize,
    measured: &'a Measured,
    robot: &'a Robot,
    /// The joints shown in the left and the right leg.
    legs: [[usize; JOINTS.len()]; 2],
}

/// A curve of a panel: its ink, its points and the joint's effort limit in N m.
type Curve = (Ink, Vec<(f64, f64)>, f64);

/// The figure, if at least one arm has a trace.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let all: Vec<Traced> =
        input.arms.iter().enumerate().filter_map(|(place, arm)| traced(place, arm)).collect();
    let first = all.first()?;
    let mut drawing = Drawing::new(880.0, 650.0, "Joint torques");
    let names = labels(&input.arms);
    let entry = |traced: &Traced| Entry {
        stroke: Stroke::solid(Ink::Arm(traced.arm), 1.8),
        text: names[traced.arm].clone(),
    };
    legend(&mut drawing, [64.0, 22.0], &all.iter().map(entry).collect::<Vec<_>>());
    let grid = Area { left: 64.0, top: 64.0, width: 796.0, height: 536.0 };
    for row in 0..JOINTS.len() {
        for leg in [0, 1] {
            let area = grid.cell([2, JOINTS.len()], [leg, row], [72.0, 62.0]);
            let curves: Vec<Curve> = all.iter().map(|traced| traced.curve(leg, row)).collect();
            panel(&mut drawing, area, &curves, leg, row);
        }
    }
    let engine = first.measured.evaluation.engine.as_str();
    Some(Figure {
        id: ID.to_string(),
        title: "Joint torques".to_string(),
        caption: format!(
            "Torque commanded to the joints over two cycles from the middle of one episode per arm (n = 1 \
             each) in {engine}, from the start of a cycle (the last 1.6 s of an episode that ended sooner). \
             Dashed: effort limit, where it is within reach; where the arms' limits differ, in their colours."
        ),
        drawing,
        sources: sources(input, |arm| {
            traced(0, arm).map(|traced| traced.measured.stage.clone()).into_iter().collect()
        }),
    })
}

/// An arm with its first evaluation that traces all joint torques; `None` if a leg does not have three pitch
/// joints.
fn traced(place: usize, arm: &Arm) -> Option<Traced<'_>> {
    let robot = arm.robot.as_ref()?;
    let joints = |side| Some(Leg::pitches(robot, side)?.map(|(joint, _)| joint));
    let legs = [joints(0)?, joints(1)?];
    let is_complete = |measured: &&Measured| {
        let trace = &measured.evaluation.trace;
        let all_joints = |torque: &Vec<f64>| torque.len() == robot.joints();
        trace.time.len() > 1 && trace.torque.len() == trace.time.len() && trace.torque.iter().all(all_joints)
    };
    let measured = arm.evaluations.iter().find(is_complete)?;
    Some(Traced { arm: place, measured, robot, legs })
}

impl Traced<'_> {
    /// The torque of a joint of a leg.
    fn curve(&self, leg: usize, row: usize) -> Curve {
        let (joint, trace) = (self.legs[leg][row], &self.measured.evaluation.trace);
        let rows = window::cycles(trace, 2, 1.6);
        let start = trace.time[rows.start];
        let points = rows.map(|row| (trace.time[row] - start, trace.torque[row][joint])).collect();
        (Ink::Arm(self.arm), points, self.robot.links[joint].joint.effort_limit)
    }
}

/// The effort limits that a curve approaches, in the arms' own inks if they differ.
fn limits(curves: &[Curve]) -> Vec<(Ink, f64)> {
    let near = |(_, points, limit): &&Curve| points.iter().any(|(_, torque)| torque.abs() > 0.5 * limit);
    let differ = curves.windows(2).any(|pair| pair[0].2 != pair[1].2);
    let own = curves.iter().filter(near).map(|(ink, _, limit)| (*ink, *limit));
    if differ { own.collect() } else { own.take(1).map(|(_, limit)| (Ink::Reference, limit)).collect() }
}

fn panel(drawing: &mut Drawing, area: Area, curves: &[Curve], leg: usize, row: usize) {
    let all = || curves.iter().flat_map(|(_, points, _)| points);
    let levels: Vec<(Ink, f64)> =
        limits(curves).into_iter().flat_map(|(ink, limit)| [(ink, limit), (ink, -limit)]).collect();
    let end = all().map(|(time, _)| *time).fold(0.0, f64::max);
    let x_label = if row + 1 == JOINTS.len() { "time since the start of a cycle (s)" } else { "" };
    let heights = all().map(|(_, y)| *y).chain(levels.iter().map(|(_, level)| *level));
    let panel = Panel {
        area,
        x: Axis::over(x_label, [0.0, end.max(1e-6)], 6),
        y: Axis::from_zero(if leg == 0 { "torque (N m)" } else { "" }, heights, 4),
    };
    panel.frame(drawing, &format!("{} {}", ["left", "right"][leg], JOINTS[row]));
    panel.level(drawing, 0.0, Stroke::solid(Ink::Muted, 0.8));
    levels.iter().for_each(|(ink, level)| panel.level(drawing, *level, Stroke::dashed(*ink, 1.2)));
    // The first arm is drawn last, on top.
    for (ink, points, _) in curves.iter().rev() {
        panel.line(drawing, points, Stroke::solid(*ink, 1.3).faint(0.9));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::{Evaluation, Trace};
    use crate::robot::tests::robot;

    /// An arm in which each joint is commanded its index in N m.
    fn arm(name: &str) -> Arm {
        let robot = robot(name);
        let torque: Vec<f64> = (0..robot.joints()).map(|joint| joint as f64).collect();
        let trace = Trace { time: vec![0.0, 0.1], torque: vec![torque; 2], ..Trace::default() };
        let measured =
            Measured { evaluation: Evaluation { trace, ..Evaluation::default() }, ..Measured::default() };
        Arm { name: name.to_owned(), robot: Some(robot), evaluations: vec![measured], ..Arm::default() }
    }

    #[test]
    fn a_panel_shows_the_joint_that_it_names_whatever_the_order_of_the_hip() {
        let (tocabi, g1) = (arm("tocabi"), arm("g1"));
        let of = |arm| traced(0, arm).expect("a trace").legs;
        assert_eq!(of(&tocabi), [[2, 3, 4], [8, 9, 10]], "yaw, roll, pitch");
        assert_eq!(of(&g1), [[0, 3, 4], [6, 9, 10]], "pitch, roll, yaw");
        let (_, points, _) = traced(0, &g1).expect("a trace").curve(1, 0);
        assert_eq!(points[0], (0.0, 6.0));
    }

    #[test]
    fn every_arm_has_the_limit_of_its_own_robot() {
        let curve = |place: usize, limit: f64| (Ink::Arm(place), vec![(0.0, 60.0)], limit);
        assert_eq!(limits(&[curve(0, 100.0), curve(1, 80.0)]), [(Ink::Arm(0), 100.0), (Ink::Arm(1), 80.0)]);
        assert_eq!(limits(&[curve(0, 100.0), curve(1, 100.0)]), [(Ink::Reference, 100.0)]);
        assert_eq!(limits(&[curve(0, 500.0), curve(1, 80.0)]), [(Ink::Arm(1), 80.0)], "out of reach");
    }
}
