//! The motion stage: the reference motion on the robot's own geometry.

use crate::exec::work::{Job, Work, WorkError};
use crate::kinds::motion::{self, clip::Clip};
use crate::kinds::task::Task;
use crate::robot::Robot;
use crate::spec::Section;
use crate::spec::typed::InSection;

/// Writes `motion.json`.
pub struct MotionWork;

impl Work for MotionWork {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot: Robot = job.read("robot", "robot.json")?;
        let absent = |section: &str| WorkError::failed(format!("the plan has no section `{section}`"));
        let name = Task::named_motion(Section::new(job.fields)).ok_or_else(|| absent(Task::SECTION))?;
        let file = job.section(motion::SECTION).ok_or_else(|| absent(motion::SECTION))?;
        let motion =
            motion::build(&name, file, &robot, file.value(Clip::TEXT).as_deref()).map_err(|error| {
                WorkError::failed(format!("the motion `{name}` does not suit {}: {error}", robot.name))
            })?;
        job.write("motion.json", &motion)
    }
}
