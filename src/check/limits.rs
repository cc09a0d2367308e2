//! W0502 and W0506: exploration against the limits of the actions and of the motors.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::robot::Joint;

/// Exploration beyond which nearly no sample lies, in standard deviations.
const WIDTH: f64 = 3.0;

/// The standard deviation stays below the range of the actions, and a position action does not ask more torque than
/// the joint has.
pub fn exploration_stays_within_limits(subject: &Subject, sink: &mut Sink) {
    ["action.std", "fine_tune.std"].iter().for_each(|path| exploration_of(subject, path, sink));
}

fn exploration_of(subject: &Subject, path: &str, sink: &mut Sink) {
    let Some(std) = subject.number(path) else { return };
    let of_ranges =
        subject.kind("action") == Some("position") && subject.text("action.shares_of") != Some("effort_limits");
    if std > 1.0 {
        let reference = if of_ranges { "half range" } else { "effort limit" };
        let written = subject.written(path);
        let message =
            format!("the exploration ({written}) is wider than the actions: 100 % is each joint's {reference}");
        sink.emit(
            placed(subject, path, Diagnostic::warning("W0502", message)).help("the paper explores with 5 % to 20 %"),
        );
    } else if of_ranges && let Some(stiffness) = subject.number("action.stiffness") {
        exploration_torque(subject, stiffness, (path, std), sink);
    }
}

/// The joint whose exploration torque exceeds its effort limit the most.
fn exploration_torque(subject: &Subject, stiffness: f64, (path, std): (&str, f64), sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let torque = |joint: &Joint| WIDTH * stiffness * joint.stiffness_gain * std * (joint.upper - joint.lower) / 2.0;
    let excess = |joint: &Joint| torque(joint) / joint.effort_limit;
    let joints = || robot.links.iter().map(|link| &link.joint).filter(|joint| joint.effort_limit > 0.0);
    let Some(worst) = joints().reduce(|worst, joint| if excess(joint) > excess(worst) { joint } else { worst }) else {
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
        "the exploration asks {} N m of `{}`, which has {} N m{also}",
        short(torque(worst)),
        worst.name,
        short(worst.effort_limit)
    );
    let reason = format!(
        "3 * {} std * {} rad half range * {} stiffness * {} N m/rad gain",
        subject.written(path),
        short((worst.upper - worst.lower) / 2.0),
        subject.written("action.stiffness"),
        short(worst.stiffness_gain)
    );
    let advice =
        format!("with this std, a stiffness of {} % stays within the limit", short(100.0 * stiffness / excess(worst)));
    let mut diagnostic = placed(subject, path, Diagnostic::warning("W0506", message));
    if let Some(place) = subject.place("action.stiffness") {
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
        let text = format!("action = {{ kind = \"position\", stiffness = {stiffness:?}, std = {std:?} }}");
        found(exploration_stays_within_limits, &text, Some(&biped()))
    }

    #[test]
    fn the_papers_failing_case_is_named_with_joint_and_numbers() {
        // 3 * 0.01 * 3 rad * 5000 N m/rad = 450 N m at the hip roll with its 232 N m; the knee: 3 * 0.01 * 1.75 * 3700 = 194 of 289.
        let found = position(1.0, 0.01);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].code, "W0506");
        assert_eq!(found[0].message, "the exploration asks 450 N m of `hip_roll`, which has 232 N m");
        assert_eq!(found[0].help, ["with this std, a stiffness of 51.56 % stays within the limit"]);
    }

    #[test]
    fn shares_of_the_effort_limits_ask_for_no_more_than_that() {
        let said = |std: f64| {
            let text = format!(
                "action = {{ kind = \"position\", stiffness = 1.0, shares_of = \"effort_limits\", std = {std:?} }}"
            );
            found(exploration_stays_within_limits, &text, Some(&biped()))
        };
        assert_eq!(said(0.1), []);
        assert_eq!(said(2.0).len(), 1);
        assert!(said(2.0)[0].message.ends_with("100 % is each joint's effort limit"));
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
        let torque = found(exploration_stays_within_limits, "action = { kind = \"torque\", std = 0.1 }", None);
        assert_eq!(torque, []);
    }
}
