//! Runs the checks of `robot show` on the result of an import, so that an unusable robot is reported when its
//! file is written, not when it is first used.

use std::collections::BTreeSet;

use super::fill::{Fill, figure};
use super::welded::Welded;
use crate::robot::{Issue, Robot, checks, examine, file, load, symmetry};

/// The findings for the text of a robot's file. If lines are to be filled in, only the rest is checked.
pub fn issues(welded: &Welded, fills: &[Fill], written: Draft<'_>) -> Vec<Issue> {
    if written.is_whole { load::issues(written.name, written.text) } else { of_known(welded, fills) }
}

/// The text of a robot's file to be written.
#[derive(Clone, Copy, Debug)]
pub struct Draft<'a> {
    /// The robot's name.
    pub name: &'a str,
    /// The text.
    pub text: &'a str,
    /// Whether no values are missing.
    pub is_whole: bool,
}

/// The findings for the known values.
fn of_known(welded: &Welded, fills: &[Fill]) -> Vec<Issue> {
    let known = Known::of(welded, fills);
    let mut robot = known.robot;
    let mut issues: Vec<Issue> = robot
        .links
        .iter()
        .zip(&known.keys)
        .enumerate()
        .flat_map(|(index, (link, keys))| {
            let path = format!("links.{index}.joint");
            let issues = checks::joint(&path, &link.joint);
            issues.into_iter().filter(|issue| is_known(&issue.path, keys)).collect::<Vec<_>>()
        })
        .collect();
    match symmetry::mirror_map(&robot) {
        // The sides are compared only if all values are known.
        Ok(mirror) if known.keys.iter().all(|keys| keys.len() == ALL) => robot.mirror = mirror,
        Ok(_) => {}
        Err(unpaired) => issues.push(file::unmirrored(&robot, &unpaired)),
    }
    let weighed = !welded.weigh_base && welded.links.iter().all(|link| !link.weigh);
    let shod = welded.feet.iter().all(|(_, sole)| sole.is_some());
    let posed = known.keys.iter().all(|keys| keys.contains("default_position"));
    // An impossible pose, or sides without mirror images, would cause all further errors of the pose.
    let examined = if issues.is_empty() && weighed && shod && posed {
        let geared = known.keys.iter().all(|keys| keys.contains("stiffness_gain"));
        let mut found = examine::issues(examine::all(&robot));
        found.retain(|issue| geared || issue.code != examine::SERVO);
        found
    } else {
        examine::issues(examine::figures(&robot))
    };
    issues.extend(examined);
    issues
}

/// Number of parameters of a joint.
const ALL: usize = 10;

/// Whether all values that a finding about a joint depends on are known.
fn is_known(path: &str, keys: &BTreeSet<&str>) -> bool {
    let has = |wanted: &[&str]| wanted.iter().all(|key| keys.contains(key));
    match path.rsplit('.').next() {
        Some("lower") => has(&["lower", "upper"]),
        Some("default_position") => has(&["lower", "upper", "default_position"]),
        Some(key) => has(&[key]),
        None => false,
    }
}

/// A robot whose unknown values are zero, and the known keys of each joint.
struct Known {
    robot: Robot,
    keys: Vec<BTreeSet<&'static str>>,
}

impl Known {
    fn of(welded: &Welded, fills: &[Fill]) -> Self {
        let mut robot = welded.skeleton();
        let mut keys = vec![BTreeSet::new(); robot.joints()];
        for ((link, moving), keys) in robot.links.iter_mut().zip(&welded.links).zip(&mut keys) {
            let joint = &mut link.joint;
            let hinge = &moving.hinge;
            let own: [(&'static str, Option<f64>, &mut f64); ALL] = [
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
            for (key, known, place) in own {
                if let Some(known) = figure(key, hinge, known, fills, welded) {
                    *place = known;
                    keys.insert(key);
                }
            }
        }
        Self { robot, keys }
    }
}
