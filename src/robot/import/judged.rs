//! The checks of `robot show` over what an import writes: what makes a robot unusable is told when its file
//! is written, not when it is first used.

use std::collections::BTreeSet;

use super::fill::{Fill, figure};
use super::welded::Welded;
use crate::robot::{Issue, Robot, checks, examine, file, load, symmetry};

/// What the checks find in the written text of a robot's file. One with lines to fill in is judged by what it
/// has.
pub fn issues(welded: &Welded, fills: &[Fill], written: Draft<'_>) -> Vec<Issue> {
    if written.is_whole { load::issues(written.name, written.text) } else { of_known(welded, fills) }
}

/// The text of a robot's file as it is written.
#[derive(Clone, Copy, Debug)]
pub struct Draft<'a> {
    /// The robot's name.
    pub name: &'a str,
    /// The text.
    pub text: &'a str,
    /// Whether no line of it is to be filled in.
    pub is_whole: bool,
}

/// What the checks find in those figures that are known.
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
        // Sides are compared when no figure of either is open.
        Ok(mirror) if known.keys.iter().all(|keys| keys.len() == ALL) => robot.mirror = mirror,
        Ok(_) => {}
        Err(unpaired) => issues.push(file::unmirrored(&robot, &unpaired)),
    }
    let weighed = !welded.weigh_base && welded.links.iter().all(|link| !link.weigh);
    let shod = welded.feet.iter().all(|(_, sole)| sole.is_some());
    let posed = known.keys.iter().all(|keys| keys.contains("default_position"));
    // A pose that the robot cannot have, or sides without an image, are the cause of whatever else the pose
    // lacks.
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

/// How many figures a joint has.
const ALL: usize = 10;

/// Whether everything that a finding about a joint depends on is known.
fn is_known(path: &str, keys: &BTreeSet<&str>) -> bool {
    let has = |wanted: &[&str]| wanted.iter().all(|key| keys.contains(key));
    match path.rsplit('.').next() {
        Some("lower") => has(&["lower", "upper"]),
        Some("default_position") => has(&["lower", "upper", "default_position"]),
        Some(key) => has(&[key]),
        None => false,
    }
}

/// A robot whose unknown figures are zero, and which of each joint are known.
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
                if let Some(known) = figure(key, hinge, known, (fills, welded)) {
                    *place = known;
                    keys.insert(key);
                }
            }
        }
        Self { robot, keys }
    }
}
