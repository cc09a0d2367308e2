//! W0412 and W0417: soles that are too large for their leg, too far from their ankle or above it, and soles that are not
//! mirror images of each other.

use nalgebra::{Isometry3, Point3, Vector3};

use super::scale::short;
use super::{Examined, Outlier, worst};
use crate::robot::checks::Issue;
use crate::robot::kinematics::Kinematics;
use crate::robot::legs;
use crate::robot::model::{Foot, Robot};

/// Largest length, width and height of a sole's box relative to the leg. Small robots with large feet have a
/// length of 0.7 and a width of 0.45, and boots a height of 0.2.
const SIZES: [f64; 3] = [1.0, 0.7, 0.35];
/// Largest distance between the last joint and the sole's centre relative to the leg's longest link: a point foot
/// is as far away as a shank is long.
const AWAY: f64 = 1.3;
/// Difference of the soles' sizes, as a share of the larger one, up to which they agree.
const SHARE: f64 = 0.1;
/// The same for their places, as a share of the sole's length, and in m for small soles.
const PLACE: f64 = 0.06;
const NEAR: f64 = 0.005;
/// Cosine of the angle between the soles' normals up to which their places are compared.
const PARALLEL: f64 = 0.99;

/// The soles fit the legs and mirror each other.
pub fn check(robot: &Robot) -> Examined {
    let leg = leg(robot);
    let link = links(robot).into_iter().flatten().fold(0.0, f64::max);
    let large = robot
        .feet
        .iter()
        .zip(["left", "right"])
        .flat_map(|(foot, side)| large(foot, side, [leg, link]))
        .collect();
    let help = "write half of the sole's length, width and thickness, and the centre of its box in the frame of \
        the foot's link, in m";
    let mut issues: Vec<Issue> = worst("W0412", large, "figures", help).into_iter().collect();
    if issues.is_empty() {
        issues.extend(worst("W0412", above(robot), "soles", help));
    }
    if issues.is_empty() {
        issues.extend(unlike(robot));
    }
    let [x, y, z] = (2.0 * robot.feet[0].half_extents).into();
    Examined {
        name: "the soles fit the legs and mirror each other",
        detail: format!("{x:.3} x {y:.3} x {z:.3} m at legs of {leg:.3} m"),
        issues,
    }
}

/// Length of the longer leg in m: the sum of its links, which no pose and no sole changes.
fn leg(robot: &Robot) -> f64 {
    links(robot).into_iter().map(|links| links.iter().sum::<f64>()).fold(0.0, f64::max)
}

/// The lengths in m of the links of each leg. The joint next to the base is the hip, whose own offset is part
/// of the base.
fn links(robot: &Robot) -> [Vec<f64>; 2] {
    let kinematics = Kinematics::new(robot);
    [0, 1].map(|side| {
        let own = legs::own(&kinematics, side);
        let links = own.iter().take(own.len().saturating_sub(1));
        links.map(|joint| robot.links[*joint].joint.origin.translation.vector.norm()).collect()
    })
}

/// The figures of a sole that exceed those of its leg and its longest link, both in m.
fn large(foot: &Foot, side: &str, [leg, link]: [f64; 2]) -> Vec<Outlier> {
    // A robot of a single joint per leg has no links to compare with.
    if link <= 0.0 {
        return Vec::new();
    }
    let sizes = ["long", "wide", "tall"].iter().zip(SIZES).enumerate().map(|(axis, (word, most))| {
        let size = 2.0 * foot.half_extents[axis];
        (size / (most * leg), "half_extents", format!("the {side} sole is {} m {word}", short(size)))
    });
    let away = foot.centre.coords.norm();
    let words = format!("the centre of the {side} sole is {} m from its joint", short(away));
    sizes
        .chain([(away / (AWAY * link), "centre", words)])
        .filter(|(excess, ..)| *excess > 1.0)
        .map(|(excess, key, words)| Outlier {
            excess,
            path: format!("feet.{side}.{key}"),
            message: format!("{words}, and the leg is {} m long", short(leg)),
        })
        .collect()
}

/// Soles whose lower face is above the last joint of the leg, in the default pose with the base upright.
fn above(robot: &Robot) -> Vec<Outlier> {
    let kinematics = Kinematics::new(robot);
    let found = robot.feet.iter().zip(["left", "right"]).filter_map(|(foot, side)| {
        let pose = kinematics.pose(foot.link);
        let lower = foot.centre - Vector3::z() * foot.half_extents.z;
        let over = (pose * lower).z - pose.translation.z;
        (over > 0.0).then(|| Outlier {
            excess: over,
            path: format!("feet.{side}.centre"),
            message: format!("the {side} sole is {:.0} mm above its ankle", 1e3 * over),
        })
    });
    found.collect()
}

/// Soles of different sizes, or in different places below their ankles.
fn unlike(robot: &Robot) -> Option<Issue> {
    let [left, right] = &robot.feet;
    let issue = |key: &str, message: String, help: String| Issue {
        code: "W0417",
        path: format!("feet.right.{key}"),
        message,
        help: format!("{help}, or, where the machine differs, allow this warning with the reason"),
    };
    let apart = |axis: usize| {
        let [one, other] = [left, right].map(|foot| foot.half_extents[axis]);
        (one - other).abs() > SHARE * one.max(other)
    };
    if (0..3).any(apart) {
        let shown = |foot: &Foot| {
            let [x, y, z] = (2e3 * foot.half_extents).into();
            format!("{x:.0} x {y:.0} x {z:.0} mm")
        };
        let message = format!("the left sole has {} and the right one {}", shown(left), shown(right));
        return Some(issue("half_extents", message, "write the same size on both sides".to_owned()));
    }
    if robot.mirror.is_empty() {
        return None;
    }
    // With all joints at zero a robot with a mirror map is symmetric.
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let poses = robot.feet.each_ref().map(|foot| *kinematics.pose(foot.link));
    // A turned frame is a tilted sole (E0420).
    let [left_normal, right_normal] = poses.each_ref().map(|pose| pose.rotation * Vector3::z());
    if Vector3::new(left_normal.x, -left_normal.y, left_normal.z).dot(&right_normal) < PARALLEL {
        return None;
    }
    let below = |side: usize| poses[side].rotation * robot.feet[side].centre.coords;
    let [own, other] = [below(0), below(1)];
    let wanted = Vector3::new(own.x, -own.y, own.z);
    let off = (wanted - other).norm();
    if off <= NEAR.max(PLACE * left.half_extents.x) {
        return None;
    }
    let place = Point3::from(poses[1].rotation.inverse() * wanted);
    let [x, y, z] = [place.x, place.y, place.z].map(|value| (value * 1e4).round() / 1e4 + 0.0);
    let message = format!(
        "the right sole is {:.0} mm away from the mirror image of the left one, below its ankle",
        1e3 * off
    );
    let help = format!("write `centre = [\"{x} m\", \"{y} m\", \"{z} m\"]` in [feet.right]");
    Some(issue("centre", message, help))
}
