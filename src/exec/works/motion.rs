//! The motion stage: the reference motion on the robot's own geometry.

use crate::exec::work::{Job, Work, WorkError};
use crate::kinds::motion;
use crate::robot::Robot;

/// Writes `motion.json`.
pub struct MotionWork;

impl Work for MotionWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot: Robot = job.read("robot", "robot.json")?;
        let absent = |section: &str| WorkError::failed(format!("the plan has no section `{section}`"));
        let name = job.section("task").ok_or_else(|| absent("task"))?.text("motion");
        let file = job.section("motion").ok_or_else(|| absent("motion"))?;
        let motion = motion::build(name, file, &robot, file.text_if("clip"))
            .map_err(|error| WorkError::failed(format!("the motion `{name}` does not suit {}: {error}", robot.name)))?;
        job.write("motion.json", &motion)
    }
}
