//! The robot stage: the validated model, with its payload and the joint values that the spec sets, as an
//! artefact.

use crate::exec::work::{Job, Work, WorkError};
use crate::robot::{Robot, stated};
use crate::spec::Table;

/// Writes `robot.json`.
pub struct RobotWork;

impl Work for RobotWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot = resolved(&job.stage.recipe.content, job.fields);
        let robot =
            robot.map_err(|error| WorkError::failed(format!("the plan's robot cannot be read: {error}")))?;
        job.write("robot.json", &robot)
    }
}

/// The model of a stage. The plan stores it resolved, so that its numbers are part of the fingerprint.
pub fn resolved(content: &serde_json::Value, fields: &Table) -> Result<Robot, serde_json::Error> {
    let robot: Robot = serde_json::from_value(content.clone())?;
    let mut robot = stated::loaded(&robot, fields).into_owned();
    stated::state(&mut robot, fields);
    Ok(robot)
}
