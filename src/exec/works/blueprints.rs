//! The environment and the controller as validated, human-readable files.

use serde::Serialize;

use super::{Job, Work, WorkError, failed};
use crate::deploy::law::{LowLevel, Output, outputs};
use crate::env::Blueprint;
use crate::kinds::action::Action;
use crate::robot::Robot;

/// `env.json`: the blueprint of the environment.
pub struct Env;

impl Work for Env {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot = job.read("robot", "robot.json")?;
        let motion = match job.inputs.contains_key("motion") {
            true => Some(job.read("motion", "motion.json")?),
            false => None,
        };
        let blueprint = Blueprint::new(job.fields.clone(), robot, motion).map_err(failed)?;
        job.write("env.json", &blueprint)
    }
}

/// `controller.json`: the low-level controller and the meaning of each policy output.
pub struct Controller;

#[derive(Serialize)]
struct Control {
    law: LowLevel,
    outputs: Vec<Output>,
}

impl Work for Controller {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot: Robot = job.read("robot", "robot.json")?;
        let action: Action =
            job.part().ok_or_else(|| WorkError::failed("the spec has no section [action]"))?;
        job.write(
            "controller.json",
            &Control { law: LowLevel::new(&action, &robot), outputs: outputs(&action, &robot) },
        )
    }
}
