//! The robot stage: the validated model, with its payload and the joint values that the spec sets, as an
//! artefact.

use nalgebra::Point3;

use crate::exec::work::{Job, Work, WorkError};
use crate::robot::{Robot, stated};
use crate::spec::{Section, Table, section};

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
    let mut robot: Robot = serde_json::from_value(content.clone())?;
    let payload = Section::new(fields).at(section::Robot::payload);
    robot.base.load(payload.unwrap_or(0.0), Point3::origin());
    stated::state(&mut robot, fields);
    Ok(robot)
}
