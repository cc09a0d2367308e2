//! W0423: squats with jumps in joint velocity.
//!
//! No motor can follow them. The cause is a squat from straight knees: the knee angle grows as the square
//! root of the descent, and thus starts at its maximum velocity. Running steps and recordings have impacts,
//! and are not checked.

use super::Subject;
use super::reference::OnDemand;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::Motion;
use crate::kinds::task::{Task, Walk};
use crate::robot::Robot;

/// Minimum jump of a joint's velocity between samples, relative to its maximum, that is reported.
const CORNER: f64 = 0.5;
/// Velocity in rad/s below which a joint is at rest.
const REST: f64 = 0.2;

/// A jump of a joint's velocity.
struct Corner {
    joint: usize,
    phase: f64,
    /// rad/s before and after.
    velocity: [f64; 2],
}

/// Warns of the largest jump in joint velocity of a squat's reference motion.
pub fn squats_are_smooth(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    if !Task::meaning_in(subject.spec()).is_some_and(|task| task.smooth) {
        return;
    }
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Ok(motion) = &made.motion else { return };
    let Some(Corner { joint, phase, velocity: [before, after] }) = corner(motion, robot) else { return };
    let name = subject.motion();
    let message = format!(
        "in the reference motion `{name}` the velocity of joint `{}` of `{}` jumps from {before:.2} to \
         {after:.2} rad/s at phase \
         {phase:.2}",
        robot.links[joint].joint.name, robot.name
    );
    let mut diagnostic = Diagnostic::warning("W0423", message);
    if let Some(place) = subject.place(&Walk::motion.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    sink.emit(diagnostic.help(
        "bend the knees in the robot's file, for example with `default_position` \"-0.3 rad\" for the hip, \
         \"0.6 rad\" for the knee and \
         \"-0.3 rad\" for the ankle",
    ));
}

/// The largest jump of a joint's velocity, relative to the joint's maximum.
fn corner(motion: &Motion, robot: &Robot) -> Option<Corner> {
    let count = motion.samples.len();
    // Differences of adjacent positions: central ones would spread a jump over two samples.
    let velocity = |index: usize, joint: usize| {
        let [before, after] = [index, index + 1].map(|index| motion.samples[index % count].position[joint]);
        (after - before) * count as f64 / motion.period
    };
    let mut worst: Option<(f64, Corner)> = None;
    for joint in 0..robot.joints() {
        let highest = (0..count).map(|index| velocity(index, joint).abs()).fold(0.0, f64::max);
        for index in (0..count).filter(|_| highest > REST) {
            let (before, after) = (velocity((index + count - 1) % count, joint), velocity(index, joint));
            let jump = (after - before).abs() / highest;
            if jump > CORNER && worst.as_ref().is_none_or(|(most, _)| jump > *most) {
                let phase = index as f64 / count as f64;
                worst = Some((jump, Corner { joint, phase, velocity: [before, after] }));
            }
        }
    }
    worst.map(|(_, corner)| corner)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::subject::sample::table;
    use super::*;
    use crate::kinds::motion;
    use crate::robot::tests::robot;
    use crate::spec::Marks;

    fn told(robot: &Robot, motion: Motion) -> Vec<Diagnostic> {
        let fields = table("[task]\nkind = \"squat\"\nmotion = \"squat\"\n");
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
        let mut make = || Some(Arc::new(Ok(motion.clone()).into()));
        let mut sink = Sink::default();
        squats_are_smooth(&subject, &mut OnDemand { shipped: false, make: &mut make }, &mut sink);
        sink.diagnostics
    }

    #[test]
    fn a_knee_whose_angle_grows_as_the_root_of_the_way_down_has_a_corner_and_shipped_squats_have_none() {
        for name in crate::robot::names() {
            let robot = robot(name);
            let made = motion::shipped("squat", &robot).expect("it is shipped").expect("it suits the robot");
            assert_eq!(told(&robot, made), [], "{name}");
        }
        let tocabi = robot("tocabi");
        let mut squat = motion::shipped("squat", &tocabi).expect("it is shipped").expect("it suits TOCABI");
        let high = squat.samples[0].position[3];
        for frame in &mut squat.samples {
            let way = frame.position[3] - high;
            frame.position[3] = high + way.abs().sqrt() * way.signum();
        }
        let found = told(&tocabi, squat);
        assert_eq!(found.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0423"]);
        assert!(
            found[0].message.contains("velocity of joint `L_Knee_Joint` of `tocabi` jumps from "),
            "{found:?}"
        );
    }
}
