//! The robot stage: the checked model, with its payload, as an artefact.

use nalgebra::Point3;

use crate::exec::work::{Job, Work, WorkError};
use crate::robot::Robot;
use crate::spec::Section;

/// Writes `robot.json`.
pub struct RobotWork;

impl Work for RobotWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        // The plan holds the resolved model, so that its numbers are part of the fingerprint.
        let mut robot: Robot = serde_json::from_value((*job.stage.recipe.content).clone())
            .map_err(|error| WorkError::failed(format!("the plan's robot cannot be read: {error}")))?;
        let payload = Section::new(job.fields).section("robot").and_then(|section| section.si_if("payload"));
        robot.base.load(payload.unwrap_or(0.0), Point3::origin());
        job.write("robot.json", &robot)
    }
}
