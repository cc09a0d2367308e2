//! E0428: motors that cannot hold the robot in its default pose, or cannot move it out of that pose against
//! friction.

use nalgebra::Isometry3;

use super::{Examined, Outlier, worst};
use crate::robot::gravity::{GravityCompensation, Weighting};
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
        let motor = format!("its motor has {} N m", joint.effort_limit);
        let (excess, reason) = if share > 1.0 {
            (share, motor)
        } else {
            // Friction alone is E0425.
            let moving = (torque + joint.friction) / joint.effort_limit;
            if moving <= 1.0 || joint.friction >= 0.8 * joint.effort_limit {
                return None;
            }
            (moving, format!("{motor}, of which friction takes {} N m", joint.friction))
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
    Examined {
        name: "the motors hold the default pose",
        detail: format!("up to {:.0} % of a limit", 100.0 * most),
        issues: worst("E0428", beyond.collect(), "joints", help).into_iter().collect(),
    }
}
