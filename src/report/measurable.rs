//! What an evaluation can measure, given the robot of the run.

use super::model::Arm;
use crate::robot::SelfCollision;

/// Whether a robot has no shapes except its soles, so that its legs' self-collisions cannot be found.
pub fn is_blind(run: &Arm) -> bool {
    run.robot.as_ref().is_some_and(|robot| !SelfCollision::is_measurable(robot))
}
