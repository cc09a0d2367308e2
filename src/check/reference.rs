//! E0509: a reference motion that the robot cannot make, or only with self-collisions where they end
//! episodes. W0422 where self-collisions end no episode.

use std::sync::{Arc, OnceLock};

use super::Subject;
use super::once::Once;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::clip::Clip;
use crate::kinds::motion::{self, Frame, Motion, MotionError};
use crate::kinds::task::Walk;
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::self_collision::SelfCollision as OfSelfCollision;
use crate::robot::examine;
use crate::robot::feet::askew;
use crate::robot::legs::own;
use crate::robot::{Kinematics, Leg, Robot, SelfCollision};
use crate::spec::{Experiment, Section, Table, Vocabulary};

/// A motion on a robot.
#[derive(Debug)]
pub struct Reference {
    /// The motion, or why it cannot be made.
    pub motion: Result<Motion, MotionError>,
    /// Its self-collision, computed on first use.
    met: OnceLock<Option<Met>>,
}

/// A self-collision in a motion.
#[derive(Clone, Debug, PartialEq)]
struct Met {
    /// Its first phase.
    phase: f64,
    /// Share of the cycle.
    share: f64,
    /// The links that collide there.
    links: [String; 2],
}

impl From<Result<Motion, MotionError>> for Reference {
    fn from(motion: Result<Motion, MotionError>) -> Self {
        Self { motion, met: OnceLock::new() }
    }
}

/// The reference motion of a spec, created on demand: this takes milliseconds, and few rules need it.
pub struct OnDemand<'a> {
    /// Whether robot and motion are embedded in the program, whose tests check that they fit.
    pub shipped: bool,
    /// The motion on the robot; `None` if the spec has no motion.
    pub make: &'a mut dyn FnMut() -> Option<Arc<Reference>>,
}

/// Cache of reference motions by robot and motion file: a suite has thousands of arms but few motions.
pub type References<K> = Once<K, Arc<Reference>>;

/// The motion on the robot.
pub fn made<K: Ord>(known: &References<K>, key: K, file: &Table, robot: &Robot) -> Arc<Reference> {
    let file = Section::new(file);
    known.get(key, || {
        Arc::new(motion::build("reference", file, robot, file.value(Clip::TEXT).as_deref()).into())
    })
}

/// Whether the spec's robot and motion are embedded in the program, or copies of those under other names.
pub fn shipped(experiment: &Experiment, vocabulary: &Vocabulary) -> bool {
    let files = [(&experiment.robot, &vocabulary.robots), (&experiment.motion, &vocabulary.motions)];
    files.into_iter().all(|(file, known)| {
        file.as_ref().is_none_or(|file| {
            let same = |text: &str| figures(text).eq(figures(&file.text));
            known.iter().any(|known| *known.text == *file.text || same(known.text))
        })
    })
}

/// The lines of a robot or motion file that decide its figures: no comments, names, sources or licences at the
/// top.
fn figures(text: &str) -> impl Iterator<Item = &str> {
    const WORDS: [&str; 4] = ["name", "summary", "source", "licence"];
    let mut at_top = true;
    text.lines().map(str::trim).filter(move |line| {
        at_top &= !line.starts_with('[');
        let key = line.split('=').next().unwrap_or_default().trim_end();
        !(line.is_empty() || line.starts_with('#') || at_top && WORDS.contains(&key))
    })
}

/// The robot can make the motion that the task names.
pub fn suits(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Err(error) = &made.motion else { return };
    let name = subject.motion();
    let message = match error {
        MotionError::Clip(flaw) => {
            format!("invalid clip of the reference motion `{name}`: {flaw}")
        }
        _ => format!("the reference motion `{name}` is infeasible for `{}`: {error}", robot.name),
    };
    let mut diagnostic = Diagnostic::error("E0509", message);
    if let Some(place) = subject.place(&Walk::motion.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    if matches!(error, MotionError::OutOfReach { .. } | MotionError::OutsideLimits { .. })
        && let Some(foot) = askew(robot)
    {
        let words = foot.in_words();
        sink.emit(diagnostic.help(match examine::unmirrored(robot) {
            Some(cause) => format!("{words}, and the motion sets feet down flat and ahead: {cause}"),
            None => format!(
                "{words}, and the motion sets feet down flat and ahead: in the robot's file choose default \
                 positions in which both soles are level, or turn the frame of the link so that z is the \
                 normal of the sole and x points forward, as `specforge robot import` does"
            ),
        }));
        return;
    }
    if let (MotionError::OutOfReach { .. }, Some(bend)) = (error, bent_knees(robot)) {
        sink.emit(diagnostic.help(bend));
        return;
    }
    let cure = match error {
        MotionError::OutOfReach { .. } if !steps_sideways(robot) => {
            "its legs have no roll joint and cannot step sideways, however short the steps are: in a motion \
             of your own, \
             `specs/motions/NAME.toml` of the same kind, write a `sway` of zero and the feet's own distance \
             as \
             `half_foot_spacing`, and name it here"
        }
        MotionError::OutOfReach { .. } => {
            "use shorter steps or smaller lengths: write `specs/motions/NAME.toml` of the same kind \
             (`specforge explain KIND` lists its keys) and name it here"
        }
        MotionError::OutsideLimits { .. } => {
            "write `specs/motions/NAME.toml` of the same kind (`specforge explain KIND` lists its keys) and \
             name it here, or correct the limits in the robot's file"
        }
        MotionError::Clip(_) => {
            "correct the recording: angles are in rad and contacts 0 or 1 (`specforge explain motion.clip` \
             documents the columns)"
        }
        MotionError::Values(_) => "write smaller numbers in the motion's file, or a longer `period`",
        MotionError::UnknownKind(_) | MotionError::Legs { .. } | MotionError::SixJoints => {
            "`specforge list motion` prints the kinds of motions, and `specforge explain KIND` the legs \
             that they need"
        }
    };
    sink.emit(diagnostic.help(cure));
}

/// The reference respects the joints' velocity limits (W0418).
pub fn stays_below_velocity_limits(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Ok(motion) = &made.motion else { return };
    let mut worst: Option<(usize, f64, f64)> = None;
    let mut beyond = vec![false; robot.joints()];
    for (index, frame) in motion.samples.iter().enumerate() {
        for (joint, velocity) in frame.velocity.iter().enumerate() {
            let share = velocity.abs() / robot.links[joint].joint.velocity_limit;
            beyond[joint] |= share > 1.0;
            if share > 1.0 && worst.is_none_or(|(.., most)| share > most) {
                worst = Some((joint, index as f64 / motion.samples.len() as f64, share));
            }
        }
    }
    let Some((joint, phase, share)) = worst else { return };
    let name = subject.motion();
    let limit = robot.links[joint].joint.velocity_limit;
    let others = beyond.iter().filter(|beyond| **beyond).count() - 1;
    let more = if others > 0 { format!(" ({others} more joints)") } else { String::new() };
    let message = format!(
        "the reference motion `{name}` turns joint `{}` of `{}` at {:.2} rad/s at phase {phase:.2}, faster \
         than its velocity limit \
         of {limit} rad/s{more}",
        robot.links[joint].joint.name,
        robot.name,
        share * limit
    );
    let mut diagnostic = Diagnostic::warning("W0418", message);
    if let Some(place) = subject.place(&Walk::motion.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    sink.emit(diagnostic.help(
        "use a slower motion, or correct `velocity_limit` in the robot's file: it is the speed of the joint \
         at the output of its gear",
    ));
}

/// Angle in rad between thigh and shank up to which a leg counts as straight: a step would require a longer
/// leg.
const STRAIGHT: f64 = 0.3;
/// Rotations about +y of hip, knee and ankle in rad that bend a leg and keep the foot level.
const BENT: [f64; 3] = [-0.3, 0.6, -0.3];

/// How to bend the knees of a robot whose default pose has straight legs.
fn bent_knees(robot: &Robot) -> Option<String> {
    let pitches = Leg::pitches(robot, 0)?;
    let kinematics = Kinematics::new(robot);
    let place = |index: usize| kinematics.pose(pitches[index].0).translation.vector;
    let (thigh, shank) = (place(1) - place(0), place(2) - place(1));
    let angle = libm::atan2(thigh.cross(&shank).norm(), thigh.dot(&shank));
    if angle > STRAIGHT || thigh.norm().min(shank.norm()) < 1e-3 {
        return None;
    }
    let fits = |way: f64| {
        pitches.iter().zip(BENT).all(|((joint, sign), bent)| {
            let joint = &robot.links[*joint].joint;
            (joint.lower..=joint.upper).contains(&(way * sign * bent))
        })
    };
    let way = [1.0, -1.0].into_iter().find(|way| fits(*way)).unwrap_or(1.0);
    let positions = pitches.iter().zip(BENT).map(|((joint, sign), bent)| {
        format!("\"{} rad\" for `{}`", way * sign * bent, robot.links[*joint].joint.name)
    });
    let positions: Vec<String> = positions.collect();
    Some(format!(
        "bend the knees of the default pose in the robot's file, so that the legs can reach further, for \
         example \
         with `default_position` {}, and mirrored on the right",
        positions.join(", ")
    ))
}

/// Number of phases of the reference checked for self-collisions.
const PHASES: u32 = 100;

/// The reference has no self-collisions: an error where they end an episode, a warning elsewhere, as such a
/// policy fails its task.
pub fn stays_apart(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot.filter(|_| !reference.shipped) else { return };
    let Some(made) = (reference.make)() else { return };
    let Ok(motion) = &made.motion else { return };
    let Some(Met { phase, share, links: [first, second] }) =
        made.met.get_or_init(|| collision(motion, robot))
    else {
        return;
    };
    let mut terms = subject.terms::<Terminations>().into_iter();
    let term = terms.find(|(_, term)| term.is::<OfSelfCollision>()).map(|(path, _)| path);
    let name = subject.motion();
    let message = format!(
        "in the reference motion `{name}` links of `{}` collide in {:.0} % of the cycle: \
         `{first}` and `{second}` at \
         phase {phase:.2}",
        robot.name,
        (100.0 * share).max(1.0)
    );
    let mut diagnostic = match term {
        Some(_) => Diagnostic::error("E0509", message),
        None => Diagnostic::warning("W0422", message),
    };
    if let Some(place) = subject.place(&Walk::motion.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    let Some(term) = term else {
        sink.emit(diagnostic.help(
            "use a motion without self-collisions, such as a shallower squat, or shrink collision shapes in \
             the robot's file that are larger than the links",
        ));
        return;
    };
    if let Some(place) = subject.place(&term) {
        diagnostic = diagnostic.note(place, "ends every episode there");
    }
    sink.emit(diagnostic.help(format!(
        "shrink collision shapes in the robot's file that are larger than the links, or remove the \
         termination with `{term}.enabled = false`"
    )));
}

/// The self-collision in the motion.
fn collision(motion: &Motion, robot: &Robot) -> Option<Met> {
    let mut guard = SelfCollision::new(robot, SelfCollision::pairs(robot));
    let mut frame = Frame::default();
    let phases = (0..PHASES).map(|step| f64::from(step) / f64::from(PHASES));
    let met = phases.filter_map(|phase| {
        motion.at(phase, &mut frame);
        guard.find(&frame.position).map(|pair| (phase, pair))
    });
    let met: Vec<_> = met.collect();
    let (phase, pair) = *met.first()?;
    let links = SelfCollision::names(robot, pair).map(str::to_owned);
    Some(Met { phase, share: met.len() as f64 / f64::from(PHASES), links })
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

    /// The diagnostics for this robot walking, with a table of terminations.
    fn found(robot: &Robot, terminate: &str) -> Vec<Diagnostic> {
        let fields = table(&format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\n{terminate}"));
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
        let mut make = || motion::shipped("walk", robot).map(|made| Arc::new(made.into()));
        let mut sink = Sink::default();
        stays_apart(&subject, &mut OnDemand { shipped: false, make: &mut make }, &mut sink);
        sink.diagnostics
    }

    /// The diagnostics for a robot that cannot walk.
    fn unsuited(robot: &Robot) -> Vec<Diagnostic> {
        let fields = table("[task]\nkind = \"walk\"\nmotion = \"walk\"\n");
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
        let mut make = || motion::shipped("walk", robot).map(|made| Arc::new(made.into()));
        let mut sink = Sink::default();
        suits(&subject, &mut OnDemand { shipped: false, make: &mut make }, &mut sink);
        sink.diagnostics
    }

    #[test]
    fn a_reference_that_is_faster_than_a_motor_is_w0418_with_joint_phase_and_figures() {
        let told = |robot: &Robot| {
            let fields = table("[task]\nkind = \"walk\"\nmotion = \"walk\"\n");
            let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(robot) };
            let mut make = || motion::shipped("walk", robot).map(|made| Arc::new(made.into()));
            let mut sink = Sink::default();
            stays_below_velocity_limits(
                &subject,
                &mut OnDemand { shipped: false, make: &mut make },
                &mut sink,
            );
            sink.diagnostics
        };
        assert_eq!(told(&robot("tocabi")), []);
        let mut slow = robot("tocabi");
        slow.links[3].joint.velocity_limit = 0.1;
        let found = told(&slow);
        assert_eq!(found.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0418"]);
        let message = &found[0].message;
        assert!(
            message.contains("turns joint `L_Knee_Joint` of `tocabi` at ")
                && message.contains("of 0.1 rad/s"),
            "{message}"
        );
        assert!(message.contains("at phase") && !message.contains("more joints"), "{message}");
    }

    #[test]
    fn straight_knees_are_the_cause_of_a_step_out_of_reach_and_the_help_works() {
        let mut straight = robot("tocabi");
        let pitches = [0, 1].map(|side| Leg::pitches(&straight, side).expect("it has them"));
        for (joint, _) in pitches.into_iter().flatten() {
            straight.links[joint].joint.default_position = 0.0;
            straight.links[joint].joint.lower = straight.links[joint].joint.lower.min(-0.1);
        }
        straight.standing_height = crate::robot::symmetry::standing_height(&straight);
        let told = unsuited(&straight);
        assert_eq!(told.iter().map(|told| told.code).collect::<Vec<_>>(), ["E0509"]);
        let help = format!("{:?}", told[0]);
        assert!(
            help.contains("bend the knees of the default pose") && help.contains("for `L_Knee_Joint`"),
            "{help}"
        );
        assert!(!help.contains("shorter steps"), "{help}");
        for ((joint, sign), bent) in pitches.into_iter().flat_map(|leg| leg.into_iter().zip(BENT)) {
            straight.links[joint].joint.default_position = sign * bent;
        }
        straight.standing_height = crate::robot::symmetry::standing_height(&straight);
        assert_eq!(unsuited(&straight), []);
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
                !help.contains("shorter steps")
                    && help.contains("default pose, and the motion sets feet down flat"),
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
        let ankle =
            armed.links.iter_mut().find(|link| link.body.name == "L_AnkleCenter_Link").expect("it has one");
        // Next to the right shank, a hand's breadth in front of it: the right leg swings into it.
        let place = Isometry3::translation(0.2, -0.2, 0.15);
        ankle.body.collisions.push(Collision { shape: Shape::Sphere(0.05), pose: place });
        let met = found(&armed, looks);
        assert_eq!(met.iter().map(|found| found.code).collect::<Vec<_>>(), ["E0509"]);
        assert!(
            met[0].message.contains("`L_AnkleCenter_Link` and `R_Knee_Link` at phase"),
            "{}",
            met[0].message
        );
        // If it ends no episode it is still reported, with its share of the cycle.
        let told = found(&armed, "");
        assert_eq!(told.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0422"]);
        let message = &told[0].message;
        let share =
            message.split(" in ").find_map(|rest| rest.split_once(" % of the cycle")).map(|(share, _)| share);
        let share: f64 = share.and_then(|share| share.parse().ok()).expect("a share");
        assert!(
            (1.0..100.0).contains(&share) && message.contains("`L_AnkleCenter_Link` and `R_Knee_Link`"),
            "{message}"
        );
        assert_eq!(found(&sound, ""), []);
    }

    /// Shipped robots and motions are not checked with each spec.
    #[test]
    fn the_motions_that_come_with_the_program_keep_the_links_of_its_robots_apart() {
        for name in crate::robot::names() {
            let robot = robot(name);
            for motion in motion::names() {
                let Some(Ok(made)) = motion::shipped(motion, &robot) else { continue };
                assert_eq!(collision(&made, &robot), None, "{name} {motion}");
            }
        }
    }
}
