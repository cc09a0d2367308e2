//! Plausibility checks of a valid model: standing in the default pose, and whether masses, lengths and drives
//! fit the units of its file.
//!
//! The only list of these checks, used by `check`, `new`, `run`, `evaluate`, `robot show` and the import. An
//! error means that no experiment can use the robot; a warning is a value far from those of known robots.

mod bend;
mod bounds;
mod drive;
mod hold;
mod level;
mod mirrored;
mod pairs;
mod pose;
mod scale;
mod servo;
mod sides;
mod size;
mod soles;

#[cfg(test)]
mod tests;

pub use bounds::{INERTIA, LENGTH, MASS};
pub use servo::{CODE as SERVO, Weak, weak};

use crate::robot::checks::Issue;
use crate::robot::model::Robot;

/// A check with its outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct Examined {
    /// The property that is checked, as a statement.
    pub name: &'static str,
    /// The value that decided the result.
    pub detail: String,
    /// The issues found; empty if the property holds.
    pub issues: Vec<Issue>,
}

/// All checks of a robot, in reporting order. Values beyond the bounds make the geometry meaningless, so the
/// other checks are then skipped.
pub fn all(robot: &Robot) -> Vec<Examined> {
    let mut found = figures(robot);
    if found.iter().flat_map(|check| &check.issues).all(|issue| issue.code != bounds::CODE) {
        let units = found.iter().flat_map(|check| &check.issues).any(|issue| issue.code == scale::CODE);
        found.push(sides::check(robot));
        found.push(pairs::check(robot, !units));
        found.push(soles::check(robot));
        found.extend(pose::checks(robot));
        found.push(hold::check(robot));
        found.push(servo::check(robot));
    }
    found
}

/// The checks of individual values: bounds, units, drives.
pub fn figures(robot: &Robot) -> Vec<Examined> {
    let bounds = bounds::check(robot);
    if !bounds.issues.is_empty() {
        return vec![bounds];
    }
    vec![bounds, scale::check(robot), drive::check(robot)]
}

/// The checks of a robot whose values an experiment changes: bounds, drives, balance and motors in the default
/// pose. Its shapes are those of a robot that has been checked, and its units are right.
pub fn changed(robot: &Robot) -> Vec<Examined> {
    let bounds = bounds::check(robot);
    if !bounds.issues.is_empty() {
        return vec![bounds];
    }
    vec![drive::check(robot), pose::balance(robot), hold::check(robot)]
}

/// The checks of the default pose.
pub fn default_pose(robot: &Robot) -> Vec<Examined> {
    pose::checks(robot)
}

/// Feet on the wrong sides (E0426), as the reason that the two sides do not match.
pub fn sides(robot: &Robot) -> Option<Issue> {
    sides::issue(robot)
}

/// Why the two sides differ in the default pose: positions that do not mirror each other, with suggestions.
pub fn unmirrored(robot: &Robot) -> Option<String> {
    mirrored::cause(robot).map(|cause| cause.help)
}

/// All issues found.
pub fn issues(checks: Vec<Examined>) -> Vec<Issue> {
    checks.into_iter().flat_map(|check| check.issues).collect()
}

/// An outlier.
struct Outlier {
    /// Its size, to select the one that is reported.
    excess: f64,
    /// Its path in the file.
    path: String,
    /// The message.
    message: String,
}

/// One issue for several outliers of one kind: the worst, and the number of others.
fn worst(code: &'static str, found: Vec<Outlier>, others: &str, help: &str) -> Option<Issue> {
    let more = found.len().saturating_sub(1);
    let worst = found.into_iter().reduce(|a, b| if b.excess > a.excess { b } else { a })?;
    let more = if more > 0 { format!(" ({more} more {others})") } else { String::new() };
    let message = worst.message + &more;
    Some(Issue { code, path: worst.path, message, help: help.to_owned() })
}

/// The path of a body in the robot's file: 0 is the base.
fn path_of(body: usize) -> String {
    body.checked_sub(1).map_or_else(|| "base".to_owned(), |link| format!("links.{link}"))
}
