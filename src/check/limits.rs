//! W0502 and W0506: exploration against the limits of actions and motors.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Action;
use crate::kinds::action::position::{Position, SharesOf, Span};
use crate::kinds::fine_tune;
use crate::robot::Joint;

/// Number of standard deviations that contain nearly all samples.
const WIDTH: f64 = 3.0;

/// The standard deviation is below the range of the actions, and exploration of a position action does not
/// require more torque than the joint has.
pub fn exploration_stays_within_limits(subject: &Subject, sink: &mut Sink) {
    [Position::std.path(), fine_tune::Ppo::std.path()]
        .iter()
        .for_each(|path| exploration_of(subject, path, sink));
}

fn exploration_of(subject: &Subject, path: &str, sink: &mut Sink) {
    let Some(std) = subject.number(path) else { return };
    let action = subject.part::<Action>();
    let servo = action.as_ref().and_then(Action::servo);
    let shares = servo.map(|servo| servo.shares_of.unwrap_or(SharesOf::Span(Span::JointRanges)));
    if std > 1.0 {
        let reference = match shares {
            Some(SharesOf::Span(Span::JointRanges)) => "each joint's half range".to_owned(),
            Some(SharesOf::Angle(angle)) => format!("{} rad at each joint", short(angle)),
            _ => "each joint's effort limit".to_owned(),
        };
        let written = subject.written(path);
        let message = format!("the exploration ({written}) exceeds the action range: 100 % is {reference}");
        sink.emit(
            placed(subject, path, Diagnostic::warning("W0502", message))
                .help("the paper explores with 5 % to 20 %"),
        );
    } else if let Some(shares) = shares.filter(|shares| *shares != SharesOf::Span(Span::EffortLimits))
        && let Some(servo) = servo
    {
        exploration_torque(subject, Exploration { stiffness: servo.stiffness, std, shares }, path, sink);
    }
}

/// The exploration of a position action.
struct Exploration {
    /// Share of the robot's own gains.
    stiffness: f64,
    /// Standard deviation, a share.
    std: f64,
    /// The reference of that share.
    shares: SharesOf,
}

impl Exploration {
    /// The joint angle of 100 %, in rad.
    fn whole(&self, joint: &Joint) -> f64 {
        match self.shares {
            SharesOf::Angle(angle) => angle,
            _ => (joint.upper - joint.lower) / 2.0,
        }
    }
}

/// The joint whose exploration torque exceeds its effort limit most.
fn exploration_torque(subject: &Subject, exploration: Exploration, path: &str, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let Exploration { stiffness, std, .. } = exploration;
    let torque = |joint: &Joint| WIDTH * stiffness * joint.stiffness_gain * std * exploration.whole(joint);
    let excess = |joint: &Joint| torque(joint) / joint.effort_limit;
    let joints = || robot.links.iter().map(|link| &link.joint).filter(|joint| joint.effort_limit > 0.0);
    let Some(worst) =
        joints().reduce(|worst, joint| if excess(joint) > excess(worst) { joint } else { worst })
    else {
        return;
    };
    if excess(worst) <= 1.0 {
        return;
    }
    let others = joints().filter(|joint| excess(joint) > 1.0).count() - 1;
    let also = match others {
        0 => String::new(),
        1 => " (and one more joint)".to_owned(),
        _ => format!(" (and {others} more joints)"),
    };
    let message = format!(
        "the exploration demands {} N m from `{}`, which has {} N m{also}",
        short(torque(worst)),
        worst.name,
        short(worst.effort_limit)
    );
    let of_range = if exploration.shares == SharesOf::Span(Span::JointRanges) { " half range" } else { "" };
    let reason = format!(
        "3 * {} std * {} rad{of_range} * {} stiffness * {} N m/rad gain",
        subject.written(path),
        short(exploration.whole(worst)),
        subject.written(&Position::stiffness.path()),
        short(worst.stiffness_gain)
    );
    let advice = format!(
        "with this std, a stiffness of {} % stays within the limit",
        short(100.0 * stiffness / excess(worst))
    );
    let mut diagnostic = placed(subject, path, Diagnostic::warning("W0506", message));
    if let Some(place) = subject.place(&Position::stiffness.path()) {
        diagnostic = diagnostic.note(place, reason);
    }
    sink.emit(diagnostic.help(advice));
}

fn placed(subject: &Subject, path: &str, diagnostic: Diagnostic) -> Diagnostic {
    match subject.place(path) {
        Some(place) => diagnostic.at(place, ""),
        None => diagnostic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::sample::biped;
    use super::super::subject::sample::found;
    use super::*;

    fn position(stiffness: f64, std: f64) -> Vec<Diagnostic> {
        let text = format!(
            "action = \
             {{ kind = \"position\", rate = 250.0, servo_rate = 500.0, stiffness = {stiffness:?}, \
             std = {std:?} }}"
        );
        found(exploration_stays_within_limits, &text, Some(&biped()))
    }

    #[test]
    fn the_papers_failing_case_is_named_with_joint_and_numbers() {
        // 3 * 0.01 * 3 rad * 5000 N m/rad = 450 N m at the hip roll (limit 232 N m); at the knee 3 * 0.01 *
        // 1.75 * 3700 = 194 (limit 289).
        let found = position(1.0, 0.01);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].code, "W0506");
        assert_eq!(found[0].message, "the exploration demands 450 N m from `hip_roll`, which has 232 N m");
        assert_eq!(found[0].help, ["with this std, a stiffness of 51.56 % stays within the limit"]);
    }

    #[test]
    fn shares_of_the_effort_limits_ask_for_no_more_than_that() {
        let said = |std: f64| {
            let text = format!(
                "action = \
                 {{ kind = \"position\", rate = 250.0, servo_rate = 500.0, stiffness = 1.0, \
                 shares_of = \"effort_limits\", std = {std:?} }}"
            );
            found(exploration_stays_within_limits, &text, Some(&biped()))
        };
        assert_eq!(said(0.1), []);
        assert_eq!(said(2.0).len(), 1);
        assert!(said(2.0)[0].message.ends_with("100 % is each joint's effort limit"));
    }

    #[test]
    fn shares_of_an_angle_count_as_that_angle() {
        let said = |angle: f64, std: f64| {
            let text = format!(
                "action = \
                 {{ kind = \"position\", rate = 250.0, servo_rate = 500.0, stiffness = 1.0, \
                 shares_of = {angle:?}, std = {std:?} }}"
            );
            found(exploration_stays_within_limits, &text, Some(&biped()))
        };
        // 3 * 0.01 * 1 rad * 5000 N m/rad = 150 N m at the hip roll (limit 232 N m).
        assert_eq!(said(1.0, 0.01), []);
        // With 3.2 rad: 480 N m, and at the knee 355 (limit 289 N m).
        let wide = said(3.2, 0.01);
        assert_eq!(
            wide[0].message,
            "the exploration demands 480 N m from `hip_roll`, which has 232 N m (and one more joint)"
        );
        assert!(said(3.2, 2.0)[0].message.ends_with("100 % is 3.2 rad at each joint"));
    }

    #[test]
    fn half_the_gains_explore_within_the_limit() {
        assert_eq!(position(0.5, 0.01), []);
        assert_eq!(position(1.0, 0.005), []);
    }

    #[test]
    fn exploration_wider_than_the_actions_is_w0502_alone() {
        let codes: Vec<_> = position(1.0, 10.0).iter().map(|diagnostic| diagnostic.code).collect();
        assert_eq!(codes, ["W0502"]);
        let torque =
            found(exploration_stays_within_limits, "action = { kind = \"torque\", std = 0.1 }", None);
        assert_eq!(torque, []);
    }
}
