//! The robot's own checks over a welded tree, as far as its figures are known: a wrong unit is told when the
//! file is written, not when it is first used.

use super::fill::{Fill, filled};
use super::welded::Welded;
use crate::quantity::parse::quantity;
use crate::robot::examine;
use crate::robot::symmetry;
use crate::robot::{Issue, Robot};

/// What the checks find in the robot that will be written with these figures filled in.
pub fn issues(welded: &Welded, fills: &[Fill]) -> Vec<Issue> {
    let (mut robot, stands, whole) = robot(welded, fills);
    if stands {
        // Sides are compared when no figure of either is open.
        if whole && let Ok(mirror) = symmetry::mirror_map(&robot) {
            robot.mirror = mirror;
        }
        return examine::issues(examine::all(&robot));
    }
    examine::issues(examine::figures(&robot))
}

/// The robot, whether everything that its default pose depends on is known, and whether every figure of its
/// joints is.
fn robot(welded: &Welded, fills: &[Fill]) -> (Robot, bool, bool) {
    let mut robot = welded.skeleton();
    let (mut posed, mut whole) = (true, true);
    for (link, moving) in robot.links.iter_mut().zip(&welded.links) {
        let joint = &mut link.joint;
        let hinge = &moving.hinge;
        let own = [
            ("lower", hinge.lower, &mut joint.lower),
            ("upper", hinge.upper, &mut joint.upper),
            ("effort_limit", hinge.effort_limit, &mut joint.effort_limit),
            ("velocity_limit", hinge.velocity_limit, &mut joint.velocity_limit),
            ("damping", hinge.damping, &mut joint.damping),
            ("friction", hinge.friction, &mut joint.friction),
            ("armature", hinge.armature, &mut joint.armature),
            ("stiffness_gain", hinge.stiffness_gain, &mut joint.stiffness_gain),
            ("damping_gain", hinge.damping_gain, &mut joint.damping_gain),
            ("default_position", hinge.default_position, &mut joint.default_position),
        ];
        for (key, _, figure) in own.into_iter().filter(|(_, known, _)| known.is_none()) {
            let fill = filled(fills, hinge, key, welded);
            match fill.and_then(|fill| quantity(&fill.value).ok()) {
                Some(filled) => *figure = filled.si,
                None => {
                    posed &= key != "default_position";
                    whole = false;
                }
            }
        }
    }
    let weighed = !welded.weigh_base && welded.links.iter().all(|link| !link.weigh);
    let shod = welded.feet.iter().all(|(_, sole)| sole.is_some());
    (robot, posed && weighed && shod, whole)
}
