//! What the robot of a run lets an evaluation measure at all.

use super::model::Arm;
use crate::robot::SelfCollision;

/// Whether the robot of a run has no shape but its soles, so that no self-collision of its legs can be found.
pub fn is_blind(run: &Arm) -> bool {
    run.robot.as_ref().is_some_and(|robot| !SelfCollision::is_measurable(robot))
}
