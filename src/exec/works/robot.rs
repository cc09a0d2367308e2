//! The robot stage: the checked model as an artefact.

use crate::exec::work::{Job, Work, WorkError};
use crate::robot::Robot;

/// Writes `robot.json`.
pub struct RobotWork;

impl Work for RobotWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        // The plan holds the resolved model, so that its numbers are part of the fingerprint.
        let robot: Robot = serde_json::from_value(job.stage.recipe.content.clone())
            .map_err(|error| WorkError::failed(format!("the plan's robot cannot be read: {error}")))?;
        job.write("robot.json", &robot)
    }
}
