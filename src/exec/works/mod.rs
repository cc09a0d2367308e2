//! What the stages do, one file per kind. The report's work stands in `cli`, above this layer.

mod motion;
mod robot;

use super::work::{Work, Works};
use crate::plan::StageKind;

/// The works of all stages below the report.
pub fn works() -> Works {
    let works: [(StageKind, Box<dyn Work>); 2] =
        [(StageKind::Robot, Box::new(robot::RobotWork)), (StageKind::Motion, Box::new(motion::MotionWork))];
    works.into_iter().collect()
}
