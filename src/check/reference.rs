//! E0509: a reference motion that the robot cannot make, or not with its links apart where they have to be.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::{self, Frame, Motion, MotionError};
use crate::robot::feet::askew;
use crate::robot::legs::own;
use crate::robot::{Kinematics, Robot, SelfCollision};
use crate::spec::{Experiment, Section, Table, Vocabulary};

/// A motion on a robot.
#[derive(Debug)]
pub struct Reference {
    /// The motion, or why there is none.
    pub motion: Result<Motion, MotionError>,
    /// Where it leads links into each other, found when it is asked for first: phase and links.
    met: OnceLock<Option<(f64, [String; 2])>>,
}

impl From<Result<Motion, MotionError>> for Reference {
    fn from(motion: Result<Motion, MotionError>) -> Self {
        Self { motion, met: OnceLock::new() }
    }
}

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
        let make = || Arc::new(motion::build("reference", file, robot, file.text_if("clip")).into());
        self.made.entry(key).or_insert_with(make).clone()
    }
}

/// Whether the spec's robot and motion come with the program.
pub fn shipped(experiment: &Experiment, vocabulary: &Vocabulary) -> bool {
    let files = [(&experiment.robot, &vocabulary.robots), (&experiment.motion, &vocabulary.motions)];
    files.into_iter().all(|(file, known)| {
        file.as_ref().is_none_or(|file| known.iter().any(|known| known.name == file.name && *known.text == *file.text))
    })
}

/// The robot can make the motion that the task names.
pub fn suits(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Err(error) = &made.motion else { return };
    let name = subject.text("task.motion").unwrap_or_default();
    let message = format!("the reference motion `{name}` does not suit `{}`: {error}", robot.name);
    let mut diagnostic = Diagnostic::error("E0509", message);
    if let Some(place) = subject.place("task.motion") {
        diagnostic = diagnostic.at(place, "");
    }
    if matches!(error, MotionError::OutOfReach { .. } | MotionError::OutsideLimits { .. })
        && let Some(foot) = askew(robot)
    {
        sink.emit(diagnostic.help(format!(
            "{}, and the motion sets feet down flat and ahead: in the robot's file choose default positions in which both soles are level, \
             or turn the frame of the link so that z is the normal of the sole and x points forward, as `specforge robot import` does",
            foot.in_words()
        )));
        return;
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

/// Phases of the reference at which links are looked at.
const PHASES: u32 = 100;

/// Where an episode ends with links inside each other, the reference keeps them apart.
pub fn stays_apart(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let terms = subject.terms("terminate").into_iter().map(|(path, _)| path);
    let Some(term) = terms.into_iter().find(|path| subject.kind(path) == Some("self_collision")) else { return };
    let Some(made) = (reference.make)() else { return };
    let Ok(motion) = &made.motion else { return };
    let Some((phase, [first, second])) = made.met.get_or_init(|| collision(motion, robot)) else { return };
    let name = subject.text("task.motion").unwrap_or_default();
    let message = format!(
        "in the reference motion `{name}` links of `{}` are inside each other: `{first}` and `{second}` at phase {phase:.2}",
        robot.name
    );
    let mut diagnostic = Diagnostic::error("E0509", message);
    if let Some(place) = subject.place("task.motion") {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some(place) = subject.place(&term) {
        diagnostic = diagnostic.note(place, "ends every episode there");
    }
    sink.emit(diagnostic.help(format!(
        "where the collision shapes in the robot's file are larger than the links, make them smaller; or switch the termination off \
         with `{term}.enabled = false`"
    )));
}

/// The first phase at which the motion leads links of the robot into each other, and their names.
fn collision(motion: &Motion, robot: &Robot) -> Option<(f64, [String; 2])> {
    let mut guard = SelfCollision::new(robot, SelfCollision::pairs(robot));
    let mut frame = Frame::default();
    (0..PHASES).map(|step| f64::from(step) / f64::from(PHASES)).find_map(|phase| {
        motion.at(phase, &mut frame);
        guard.find(&frame.position).map(|pair| (phase, SelfCollision::names(robot, pair).map(|name| name.to_string())))
    })
}

/// Whether a joint of the left leg turns about the direction of travel.
fn steps_sideways(robot: &Robot) -> bool {
    let kinematics = Kinematics::new(robot);
    own(&kinematics, 0).into_iter().any(|joint| kinematics.axis(joint).x.abs() > 0.5)
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::super::subject::sample::table;
    use super::*;
    use crate::robot::tests::robot;
    use crate::robot::{Collision, Shape};
    use crate::spec::Marks;

    /// What is found where this robot walks, with a table of terminations.
    fn found(robot: &Robot, terminate: &str) -> Vec<Diagnostic> {
        let fields = table(&format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\n{terminate}"));
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
        let mut make = || motion::shipped("walk", robot).map(|made| Arc::new(made.into()));
        let mut sink = Sink::default();
        stays_apart(&subject, &mut OnDemand { shipped: false, make: &mut make }, &mut sink);
        sink.diagnostics
    }

    /// What is found where this robot is to walk.
    fn unsuited(robot: &Robot) -> Vec<Diagnostic> {
        let fields = table("[task]\nkind = \"walk\"\nmotion = \"walk\"\n");
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
        let mut make = || motion::shipped("walk", robot).map(|made| Arc::new(made.into()));
        let mut sink = Sink::default();
        suits(&subject, &mut OnDemand { shipped: false, make: &mut make }, &mut sink);
        sink.diagnostics
    }

    #[test]
    fn shorter_steps_are_no_advice_where_a_foot_is_askew() {
        let help = |robot: &Robot| {
            let told = unsuited(robot);
            assert_eq!(told.iter().map(|told| told.code).collect::<Vec<_>>(), ["E0509"]);
            format!("{:?}", told[0])
        };
        assert_eq!(unsuited(&robot("tocabi")), []);
        let mut short = robot("tocabi");
        short.links.iter_mut().for_each(|link| {
            (link.joint.lower, link.joint.upper) =
                (link.joint.default_position - 0.01, link.joint.default_position + 0.01);
        });
        assert!(!help(&short).contains("sole"));
        for axis in [nalgebra::Vector3::x(), nalgebra::Vector3::y(), nalgebra::Vector3::z()] {
            let turn = crate::robot::kinematics::rotation_about(&axis, 1.5);
            let mut turned = robot("tocabi");
            for foot in [5, 11] {
                let joint = &mut turned.links[foot].joint;
                joint.origin.rotation *= turn;
                joint.axis = turn.inverse() * joint.axis;
            }
            let help = help(&turned);
            assert!(
                !help.contains("shorter steps") && help.contains("default pose, and the motion sets feet down flat"),
                "{help}"
            );
        }
    }

    #[test]
    fn shapes_that_the_reference_leads_into_each_other_are_e0509_where_that_ends_an_episode() {
        let looks = "[terminate.self_collision]\nkind = \"self_collision\"\n";
        let sound = robot("tocabi");
        assert_eq!(found(&sound, looks), []);
        let mut armed = sound.clone();
        let ankle = armed.links.iter_mut().find(|link| link.body.name == "L_AnkleCenter_Link").expect("it has one");
        // Beside the right shank, a hand's breadth before it: the right leg swings into it.
        let place = Isometry3::translation(0.2, -0.2, 0.15);
        ankle.body.collisions.push(Collision { shape: Shape::Sphere(0.05), pose: place });
        let met = found(&armed, looks);
        assert_eq!(met.iter().map(|found| found.code).collect::<Vec<_>>(), ["E0509"]);
        assert!(met[0].message.contains("`L_AnkleCenter_Link` and `R_Knee_Link` at phase"), "{}", met[0].message);
        assert_eq!(found(&armed, ""), []);
    }
}
