//! What the figures of a sound model say about the robot: whether it stands in its default pose, and whether
//! masses, lengths and drives have the units that their file claims.
//!
//! The only list of these checks. `check`, `new`, `run`, `evaluate`, `robot show` and the import all read it.
//! An error is a robot with which no experiment works; a warning is a figure that is far from those of known
//! robots.

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
    /// The figure behind the outcome.
    pub detail: String,
    /// What was found; empty when the property holds.
    pub issues: Vec<Issue>,
}

/// Every check of a robot, in the order in which they are reported. Figures beyond all bounds have no
/// geometry, so the other checks are left out where there are any.
pub fn all(robot: &Robot) -> Vec<Examined> {
    let mut found = figures(robot);
    if found.iter().flat_map(|check| &check.issues).all(|issue| issue.code != bounds::CODE) {
        found.push(sides::check(robot));
        found.push(pairs::check(robot));
        found.extend(pose::checks(robot));
        found.push(hold::check(robot));
        found.push(servo::check(robot));
    }
    found
}

/// The checks of single figures: bounds, units, drives.
pub fn figures(robot: &Robot) -> Vec<Examined> {
    let bounds = bounds::check(robot);
    if !bounds.issues.is_empty() {
        return vec![bounds];
    }
    vec![bounds, scale::check(robot), drive::check(robot)]
}

/// The checks of the default pose.
pub fn default_pose(robot: &Robot) -> Vec<Examined> {
    pose::checks(robot)
}

/// Feet that do not lie left and right (E0426): the cause where the sides have nothing in common.
pub fn sides(robot: &Robot) -> Option<Issue> {
    sides::issue(robot)
}

/// Why the two sides do not stand alike: default positions that do not mirror each other, with those to
/// write.
pub fn unmirrored(robot: &Robot) -> Option<String> {
    mirrored::cause(robot).map(|cause| cause.help)
}

/// Everything that was found.
pub fn issues(checks: Vec<Examined>) -> Vec<Issue> {
    checks.into_iter().flat_map(|check| check.issues).collect()
}

/// A figure that stands out.
struct Outlier {
    /// By how much, for choosing the one that is reported.
    excess: f64,
    /// Where it stands in the file.
    path: String,
    /// What it is.
    message: String,
}

/// One issue for several figures of one kind: the worst, with the number of the others.
fn worst(code: &'static str, found: Vec<Outlier>, others: &str, help: &str) -> Option<Issue> {
    let more = found.len().saturating_sub(1);
    let worst = found.into_iter().reduce(|a, b| if b.excess > a.excess { b } else { a })?;
    let more = if more > 0 { format!(" ({more} more {others})") } else { String::new() };
    let message = worst.message + &more;
    Some(Issue { code, path: worst.path, message, help: help.to_owned() })
}

/// The paths of a robot's bodies in its file: 0 is the base.
fn path_of(body: usize) -> String {
    body.checked_sub(1).map_or_else(|| "base".to_owned(), |link| format!("links.{link}"))
}
