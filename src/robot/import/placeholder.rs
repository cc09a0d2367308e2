//! Limits that no motor has: descriptions that were written for a viewer hold 1000 N m or 1000 rad/s where a figure is asked
//! for. They are taken over, because a file's figure is not ours to change, and told.

use super::tree::Hinge;
use super::welded::{Moving, Welded};
use crate::spec::suggest::listed;

/// A leg's joint that carries so many times the robot's weight at the leg's length is not of this robot; a knee that squats
/// needs about half of it.
const WEIGHTS: f64 = 5.0;
/// The speed limit in rad/s that no leg's joint reaches; the fastest are near 40.
const FASTEST: f64 = 100.0;
/// The range in rad that no leg's joint has.
const TURN: f64 = std::f64::consts::TAU;
/// Gravity in m/s^2.
const G: f64 = 9.81;
/// Joints that are named; beyond them their number is told.
const NAMED: usize = 3;

/// A remark for each sort of limit that looks like a placeholder.
pub(super) fn remarks(welded: &Welded, feet: [usize; 2]) -> Vec<String> {
    let told = |suspect: &dyn Fn(&Hinge) -> Option<f64>, say: &dyn Fn(&str, f64) -> String| {
        let found: Vec<(&str, f64)> = welded
            .links
            .iter()
            .filter_map(|link| {
                Some((link.hinge.name.as_str(), suspect(&link.hinge).filter(|value| value.is_finite())?))
            })
            .collect();
        let most = found.iter().map(|(_, value)| *value).reduce(f64::max)?;
        Some(say(&names(&found, welded.links.len()), most))
    };
    let hold = holding(welded, feet);
    let effort = |hinge: &Hinge| hinge.effort_limit.filter(|limit| hold.is_some_and(|hold| *limit > WEIGHTS * hold));
    let speed = |hinge: &Hinge| hinge.velocity_limit.filter(|limit| *limit > FASTEST);
    let range = |hinge: &Hinge| Some(hinge.upper? - hinge.lower?).filter(|range| *range > TURN);
    let remarks = [
        told(&effort, &|names, most| {
            format!(
                "the effort limit of {names}, up to {most:.0} N m, is more than {WEIGHTS:.0} times the robot's weight at the length of its \
                 leg ({:.1} N m): a placeholder? Torques are commanded as shares of it",
                hold.unwrap_or_default()
            )
        }),
        told(&speed, &|names, most| {
            format!("the velocity limit of {names}, up to {most:.0} rad/s, is beyond what legs move at: a placeholder?")
        }),
        told(&range, &|names, most| {
            format!(
                "the range of {names}, up to {most:.1} rad, is more than a turn: a placeholder? Positions are commanded within it"
            )
        }),
    ];
    remarks.into_iter().flatten().collect()
}

fn names(found: &[(&str, f64)], joints: usize) -> String {
    let named: Vec<&str> = found.iter().map(|(name, _)| *name).collect();
    match named.len() {
        count if count == joints && count > 1 => format!("all {count} joints"),
        _ => some(&named),
    }
}

/// Names for a remark; of very many the first and the number of the others.
pub(super) fn some(names: &[&str]) -> String {
    match names.len() {
        count if count > NAMED + 1 => {
            let first: Vec<String> = names.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
            format!("{} and {} others", first.join(", "), count - NAMED)
        }
        _ => listed(names.iter().copied()),
    }
}

/// The robot's weight times the length of its longer leg in N m; `None` while a mass is to be filled in.
fn holding(welded: &Welded, feet: [usize; 2]) -> Option<f64> {
    let unknown = welded.weigh_base || welded.links.iter().any(|link| link.weigh);
    let mass = welded.base.mass + welded.links.iter().map(|link| link.body.mass).sum::<f64>();
    let length = feet.map(|foot| reach(&welded.links, foot)).into_iter().fold(0.0, f64::max);
    (!unknown && mass > 0.0 && length > 0.0).then_some(mass * G * length)
}

/// The length of the chain from the base to a body, in m.
fn reach(links: &[Moving], link: usize) -> f64 {
    let own = links[link].origin.translation.vector.norm();
    own + links[link].parent.map_or(0.0, |parent| reach(links, parent))
}
