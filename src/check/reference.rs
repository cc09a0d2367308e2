//! E0509: a reference motion that the robot cannot make.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::{self, Motion, MotionError};
use crate::robot::legs::own;
use crate::robot::{Kinematics, Robot};
use crate::spec::{Experiment, Section, Table, Vocabulary};

/// A motion on a robot, or why there is none.
pub type Reference = Result<Motion, MotionError>;

/// The reference motion of a spec, made when a rule asks for it: making one takes milliseconds, and few rules need it.
pub struct OnDemand<'a> {
    /// Whether robot and motion come with the program, whose tests say that they suit each other.
    pub shipped: bool,
    /// The motion on the robot; none where there is no motion.
    pub make: &'a mut dyn FnMut() -> Option<Arc<Reference>>,
}

/// Reference motions by robot and motion file, each made once: a suite has thousands of arms and a few motions.
#[derive(Debug)]
pub struct References<K> {
    made: BTreeMap<K, Arc<Reference>>,
}

impl<K> Default for References<K> {
    fn default() -> Self {
        Self { made: BTreeMap::new() }
    }
}

impl<K: Ord> References<K> {
    /// The motion on the robot.
    pub fn get(&mut self, key: K, file: &Table, robot: &Robot) -> Arc<Reference> {
        let file = Section::new(file);
        let make = || Arc::new(motion::build("reference", file, robot, file.text_if("clip")));
        self.made.entry(key).or_insert_with(make).clone()
    }
}

/// Whether the spec's robot and motion come with the program.
pub fn shipped(experiment: &Experiment, vocabulary: &Vocabulary) -> bool {
    let files = [(&experiment.robot, &vocabulary.robots), (&experiment.motion, &vocabulary.motions)];
    files.into_iter().all(|(file, known)| {
        file.as_ref().is_none_or(|file| known.iter().any(|known| known.name == file.name && known.text == file.text))
    })
}

/// The robot can make the motion that the task names.
pub fn suits(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Err(error) = &*made else { return };
    let name = subject.text("task.motion").unwrap_or_default();
    let message = format!("the reference motion `{name}` does not suit `{}`: {error}", robot.name);
    let mut diagnostic = Diagnostic::error("E0509", message);
    if let Some(place) = subject.place("task.motion") {
        diagnostic = diagnostic.at(place, "");
    }
    let cure = match error {
        MotionError::OutOfReach { .. } if !steps_sideways(robot) => {
            "its legs have no roll joint and cannot step sideways, however short the steps are: in a copy of the motion's \
             file in `specs/motions/` under another name, write a `sway` of zero and the feet's own distance as \
             `half_foot_spacing`, and name it here"
        }
        MotionError::OutOfReach { .. } => {
            "a motion of shorter steps, or of smaller lengths altogether, is within its reach: copy the motion's file to \
             `specs/motions/` under another name, change it there and name it here"
        }
        MotionError::OutsideLimits { .. } => {
            "copy the motion's file to `specs/motions/` under another name, change it there and name it here; or, where \
             the limits in the robot's file are wrong, mend those"
        }
        MotionError::UnknownKind(_) | MotionError::Legs | MotionError::SixJoints | MotionError::Clip(_) => {
            "`specforge list motion` shows the kinds of motions, `specforge explain` what legs they are for"
        }
    };
    sink.emit(diagnostic.help(cure));
}

/// Whether a joint of the left leg turns about the direction of travel.
fn steps_sideways(robot: &Robot) -> bool {
    let kinematics = Kinematics::new(robot);
    own(&kinematics, 0).into_iter().any(|joint| kinematics.axis(joint).x.abs() > 0.5)
}
