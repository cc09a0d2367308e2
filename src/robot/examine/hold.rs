//! E0428 and W0414: motors that cannot hold the robot in its default pose, or cannot move it out of that pose against
//! friction, or that cannot hold it on one foot.

use nalgebra::Isometry3;

use super::scale::figure;
use super::{Examined, Outlier, worst};
use crate::robot::checks::Issue;
use crate::robot::gravity::{GravityCompensation, Weighting};
use crate::robot::legs;
use crate::robot::model::Robot;

/// The torques that hold the default pose on both feet are within the effort limits. A limit of zero is
/// missing in the import.
pub fn check(robot: &Robot) -> Examined {
    let mut gravity = GravityCompensation::new(robot, Weighting::EffortLimits);
    let balance = gravity.hold(&Isometry3::identity(), &robot.default_pose(), [true; 2]);
    let joints = robot.links.iter().map(|link| &link.joint).enumerate().zip(&balance.torque);
    let shares: Vec<(usize, f64, f64)> = joints
        .filter(|((_, joint), _)| joint.effort_limit > 0.0)
        .map(|((index, joint), torque)| (index, torque.abs(), torque.abs() / joint.effort_limit))
        .collect();
    let most = shares.iter().map(|(.., share)| *share).fold(0.0, f64::max);
    let beyond = shares.into_iter().filter_map(|(index, torque, share)| {
        let joint = &robot.links[index].joint;
        let motor = format!("its motor has {} N m", figure(joint.effort_limit));
        let (excess, reason) = if share > 1.0 {
            (share, motor)
        } else {
            // Friction alone is E0425.
            let moving = (torque + joint.friction) / joint.effort_limit;
            if moving <= 1.0 || joint.friction >= 0.8 * joint.effort_limit {
                return None;
            }
            (moving, format!("{motor}, of which friction takes {} N m", figure(joint.friction)))
        };
        Some(Outlier {
            excess,
            path: format!("links.{index}.joint.effort_limit"),
            message: format!(
                "standing on both feet in the default pose takes {torque:.1} N m of joint `{}`, and {reason}",
                joint.name
            ),
        })
    });
    let help = "write the largest torque of the drive at the output of its gear, or choose default positions \
        with straighter legs";
    let mut issues: Vec<_> = worst("E0428", beyond.collect(), "joints", help).into_iter().collect();
    if issues.is_empty() {
        issues.extend(on_one_foot(robot, &mut gravity));
    }
    Examined {
        name: "the motors hold the default pose",
        detail: format!("up to {:.0} % of a limit", 100.0 * most),
        issues,
    }
}

/// Share of the torque of a hip roll joint on one foot that its motor must have: leaning over the foot takes
/// away some of it.
const STEPPING: f64 = 0.4;

/// Hip roll motors that cannot hold the robot on one foot, as every step requires (W0414). The torque is that of
/// the weight beside the hip, so the ankle, which leaning relieves, is not judged.
fn on_one_foot(robot: &Robot, gravity: &mut GravityCompensation) -> Option<Issue> {
    let mut found = Vec::new();
    for side in 0..2 {
        let contact = [side == 0, side == 1];
        let torque = gravity.hold(&Isometry3::identity(), &robot.default_pose(), contact).torque.clone();
        let kinematics = gravity.kinematics();
        let height = |joint: usize| kinematics.pose(joint).translation.z;
        let own = legs::own(kinematics, side);
        let [Some(first), Some(last)] = [own.first(), own.last()] else { continue };
        let middle = 0.5 * (height(*first) + height(*last));
        let rolls = own.iter().filter(|joint| kinematics.axis(**joint).x.abs() > 0.7);
        for index in rolls.filter(|joint| height(**joint) > middle) {
            let joint = &robot.links[*index].joint;
            let share = torque[*index].abs() / joint.effort_limit;
            if joint.effort_limit > 0.0 && share * STEPPING > 1.0 {
                let message = format!(
                    "standing on one foot takes {:.1} N m of joint `{}`, and its motor has {} N m",
                    torque[*index].abs(),
                    joint.name,
                    figure(joint.effort_limit)
                );
                let path = format!("links.{index}.joint.effort_limit");
                found.push(Outlier { excess: share, path, message });
            }
        }
    }
    let help = "write the largest torque of the drive at the output of its gear, or allow this warning with the \
        reason, for a robot that never lifts a foot";
    worst("W0414", found, "joints", help)
}
