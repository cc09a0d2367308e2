//! Whether both soles are level, and the joint positions that level them.

use nalgebra::{Isometry3, Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::robot::kinematics::Kinematics;
use crate::robot::legs;
use crate::robot::model::Robot;

/// Maximum tilt of a sole in rad: it lifts the edge of a 0.2 m sole by 2 mm, as much as contacts give way.
/// Three positions rounded to a hundredth stay below it.
pub const TILT: f64 = 0.01;
/// Maximum difference of the soles' heights in m; the same tolerance as for mirror images of left and right.
pub const APART: f64 = 2e-3;

/// From this tilt in rad, the sole's frame is rotated rather than a joint off.
pub const FRAME: f64 = std::f64::consts::FRAC_PI_4;

/// Tilt of a sole in rad and its normal.
pub fn tilt(kinematics: &Kinematics, side: usize) -> (f64, Vector3<f64>) {
    let normal = kinematics.sole(side).rotation * Vector3::z();
    (libm::atan2(libm::hypot(normal.x, normal.y), normal.z), normal)
}

/// Whether both soles are level in the default pose.
pub fn is_level(robot: &Robot) -> bool {
    let kinematics = Kinematics::new(robot);
    let heights = [0, 1].map(|side| kinematics.sole(side).translation.z);
    [0, 1].iter().all(|side| tilt(&kinematics, *side).0 <= TILT) && (heights[0] - heights[1]).abs() <= APART
}

/// Tilt in rad of the steeper sole in the default pose.
pub fn steepest(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    tilt(&kinematics, 0).0.max(tilt(&kinematics, 1).0)
}

/// How to level the steeper sole of a robot with mirrored legs; `None` if it is level.
pub fn rest(robot: &Robot) -> Option<String> {
    let kinematics = Kinematics::new(robot);
    let side = usize::from(tilt(&kinematics, 1).0 > tilt(&kinematics, 0).0);
    (tilt(&kinematics, side).0 > TILT).then(|| advice(robot, &kinematics, side))
}

/// A position for display: four decimals. Adding zero turns -0 into 0.
pub fn rounded(position: f64) -> f64 {
    (1e4 * position).round() / 1e4 + 0.0
}

/// Advice if only one sole is tilted although both legs have mirrored positions.
pub fn turned(robot: &Robot, side: usize) -> String {
    let name = |side: usize| robot.links[robot.feet[side].link].body.name.as_str();
    let (foot, other) = (name(side), name(1 - side));
    format!(
        "the default positions of left and right mirror each other, so the frame of `{foot}` is turned \
         against that of `{other}`: \
         turn it until its z axis is the sole's normal, as `specforge robot import` does"
    )
}

/// How to level a sole: by the joint next to the foot that turns about the right axis, otherwise by its frame
/// or its leg.
pub fn advice(robot: &Robot, kinematics: &Kinematics, side: usize) -> String {
    let (tilt, normal) = tilt(kinematics, side);
    let foot = &robot.links[robot.feet[side].link].body.name;
    if tilt > FRAME {
        return format!(
            "turn the frame of `{foot}`: the z axis of a foot is the normal of its sole, x points forward"
        );
    }
    let needed = Unit::try_new(normal.cross(&Vector3::z()), 1e-12);
    let levels = |index: usize| {
        let joint = &robot.links[index].joint;
        let along = needed?.dot(kinematics.axis(index));
        let position = joint.default_position + along.signum() * tilt;
        (along.abs() > 0.99 && (joint.lower..=joint.upper).contains(&position))
            .then_some((&joint.name, position))
    };
    match legs::own(kinematics, side).into_iter().find_map(levels) {
        Some((joint, position)) => {
            let position = rounded(position);
            format!(
                "write `default_position = \"{position} rad\"` for joint `{joint}`, and mirrored for the \
                other leg"
            )
        }
        None => levelled(robot, side).unwrap_or_else(|| {
            format!(
                "choose default positions of the leg that level the sole, or turn the frame of `{foot}` \
                 until its z axis is the \
                 sole's normal"
            )
        }),
    }
}

/// Positions of a leg, by inverse kinematics, that level the foot at its present place. `None` if the leg
/// cannot reach it.
fn levelled(robot: &Robot, side: usize) -> Option<String> {
    let mut kinematics = Kinematics::new(robot);
    let foot = *kinematics.pose(robot.feet[side].link);
    let z = Vector3::z();
    let x = foot.rotation * Vector3::x();
    let x = Unit::try_new(x - z * x.z, 1e-3)?.into_inner();
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    let target = Isometry3::from_parts(foot.translation, UnitQuaternion::from_rotation_matrix(&turn));
    let mut position = robot.default_pose();
    let leg = legs::own(&kinematics, side);
    let residual = legs::reach(&mut kinematics, side, &target, &mut position);
    let within = |joint: &usize| {
        let own = &robot.links[*joint].joint;
        (own.lower..=own.upper).contains(&position[*joint])
    };
    if residual.is_nan() || residual > 1e-9 || !leg.iter().all(within) {
        return None;
    }
    let rounded = |joint: usize| rounded(position[joint]);
    let changed = leg
        .into_iter()
        .rev()
        .filter(|joint| (rounded(*joint) - robot.links[*joint].joint.default_position).abs() > 5e-5);
    let positions: Vec<String> = changed
        .map(|joint| format!("\"{} rad\" for `{}`", rounded(joint), robot.links[joint].joint.name))
        .collect();
    (!positions.is_empty()).then(|| {
        format!(
            "write these default positions, which level the sole where it is, and mirrored for the other \
             leg: {}",
            positions.join(", ")
        )
    })
}
