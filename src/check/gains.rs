//! E0511 and W0513: position servos that do not move their joints, or cannot hold the robot.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Action;
use crate::kinds::action::position::{Position, Targets};
use crate::robot::Robot;
use crate::robot::examine::{Weak, weak};
use crate::spec::suggest::listed;

/// Maximum number of joints listed by name; of the rest only the count is shown.
const NAMED: usize = 3;

/// Every joint has a servo, which is strong enough to hold the robot in its stance.
pub fn servos_move_their_joints(subject: &Subject, sink: &mut Sink) {
    let (Some(robot), Some(Action::Position(servo))) = (subject.robot, subject.part::<Action>()) else {
        return;
    };
    let limp: Vec<&str> = robot
        .links
        .iter()
        .map(|link| &link.joint)
        .filter(|joint| joint.stiffness_gain <= 0.0)
        .map(|joint| joint.name.as_str())
        .collect();
    if !limp.is_empty() {
        sink.emit(without_gain(subject, robot, &limp));
        return;
    }
    // Targets beyond the joint's limits can command its full torque.
    if servo.targets == Some(Targets::EffortLimits) {
        return;
    }
    let soft = weak(robot, servo.stiffness);
    let Some(worst) = soft.iter().max_by(|a, b| (a.needed / a.most).total_cmp(&(b.needed / b.most))) else {
        return;
    };
    sink.emit(too_soft(subject, robot, worst, soft.len() - 1));
}

fn without_gain(subject: &Subject, robot: &Robot, joints: &[&str]) -> Diagnostic {
    let names = match joints.len() {
        count if count == robot.joints() && count > 1 => format!("all {count} joints"),
        count if count > NAMED + 1 => {
            format!(
                "{} and {} more joints",
                joints[..NAMED].iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
                count - NAMED
            )
        }
        _ => listed(joints.iter().copied()),
    };
    let message = format!("position actions cannot move {names} of `{}`: `stiffness_gain` is 0", robot.name);
    let error = Diagnostic::error("E0511", message);
    let error = match subject.place(&Position::stiffness.path()) {
        Some(place) => error.at(place, "a share of a gain of 0"),
        None => error,
    };
    error.help(format!(
        "write the proportional gains of the servos in the robot's file (`specforge robot show {}` shows \
         them), or use torque \
         actions",
        robot.name
    ))
}

fn too_soft(subject: &Subject, robot: &Robot, weak: &Weak, others: usize) -> Diagnostic {
    let joint = &robot.links[weak.joint].joint;
    let also = match others {
        0 => String::new(),
        1 => " (and one more joint)".to_owned(),
        _ => format!(" (and {others} more joints)"),
    };
    let message = format!("the servo of `{}` {}{also}", joint.name, weak.in_words(robot));
    let path = Position::stiffness.path();
    let warning = Diagnostic::warning("W0513", message);
    let warning = match subject.place(&path) {
        Some(place) => {
            let range = (joint.upper - joint.default_position).max(joint.default_position - joint.lower);
            warning.at(
                place,
                format!(
                    "{} * {} N m/rad * {} rad",
                    subject.written(&path),
                    short(joint.stiffness_gain),
                    short(range)
                ),
            )
        }
        None => warning,
    };
    warning.help(
        "write a larger stiffness, or `targets = \"effort_limits\"`, with which a soft servo gives all of \
         the joint's torque",
    )
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;
    use crate::robot::tests::robot;

    fn said(robot: &Robot, keys: &str) -> Vec<Diagnostic> {
        let text = format!(
            "action = {{ kind = \"position\", rate = 250.0, servo_rate = 500.0, std = 0.01, {keys} }}"
        );
        found(servos_move_their_joints, &text, Some(robot))
    }

    fn codes(found: &[Diagnostic]) -> Vec<&'static str> {
        found.iter().map(|found| found.code).collect()
    }

    #[test]
    fn a_joint_without_a_gain_is_e0511_under_position_control_alone() {
        let sound = robot("tocabi");
        assert_eq!(said(&sound, "stiffness = 1.0"), []);
        for joints in [vec![3], vec![0, 1, 2, 3, 4], (0..sound.joints()).collect()] {
            let mut limp = sound.clone();
            joints.iter().for_each(|joint| limp.links[*joint].joint.stiffness_gain = 0.0);
            for keys in ["stiffness = 1.0", "stiffness = 100.0, targets = \"effort_limits\""] {
                let found = said(&limp, keys);
                assert_eq!(codes(&found), ["E0511"], "{keys}");
                let names = match joints.len() {
                    1 => "move `L_Knee_Joint` of",
                    5 => "and 2 more joints of `tocabi`",
                    _ => "all 12 joints of `tocabi`",
                };
                assert!(found[0].message.contains(names), "{}", found[0].message);
            }
            let torque = "action = { kind = \"torque\", rate = 250.0, std = 0.01 }";
            assert_eq!(found(servos_move_their_joints, torque, Some(&limp)), []);
        }
    }

    #[test]
    fn a_servo_that_cannot_hold_the_robot_within_the_joints_range_is_w0513() {
        // 0.001 of 3700 N m/rad over 2.4 rad is 8.9 N m at the knee, where standing takes about 60.
        let found = said(&robot("tocabi"), "stiffness = 0.001");
        assert_eq!(codes(&found), ["W0513"]);
        assert!(found[0].message.contains("N m within the joint's range, and "), "{}", found[0].message);
        assert_eq!(said(&robot("tocabi"), "stiffness = 0.001, targets = \"effort_limits\""), []);
    }
}
