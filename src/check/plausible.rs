//! W0523: values that are far from those of any robot or sensor: joint offsets, sensor noise, pushes, slopes on
//! which a robot slides, obstacles without a height, and evaluations far beyond the trained speeds.
//!
//! Each bound is at least five times away from the values of the shipped specs.

use super::Subject;
use super::odd::Odd;
use super::subject::short;
use crate::diag::Sink;
use crate::kinds::evaluate::{self, Episodes, Evaluation, Speeds, Spread};
use crate::kinds::initial::Initial;
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_position::JointPosition;
use crate::kinds::pretrain::Pretraining;
use crate::kinds::randomize::joint_offset::JointOffset;
use crate::kinds::randomize::push::Pushes;
use crate::kinds::task::{Command, Task, Walk};
use crate::kinds::terrain::box_obstacle::BoxObstacle;
use crate::kinds::terrain::height_field::HeightField;
use crate::kinds::terrain::slope::Slope;
use crate::robot::{GRAVITY, hip_height};
use crate::spec::Sampler;
use crate::spec::typed::{InSection, Part, Sampled, Typed};

/// Largest offset in rad of a joint's zero position; calibrated joints have 0.02.
const OFFSET: f64 = 0.5;
/// Largest noise in rad of a measured joint position; bad encoders have 0.01.
const NOISE: f64 = 0.2;
/// Largest spread in rad of joint positions at the start of an episode.
const START: f64 = 0.6;
/// Change of the robot's velocity in m/s by a push that no robot survives; hard pushes have 1.
const SHOVE: f64 = 8.0;
/// Factor on the fastest trained command beyond which an evaluation says nothing about the training.
const BEYOND: f64 = 3.0;
/// Froude number of the fastest runners, beyond which another rule reports the speed.
const FASTEST: f64 = 9.0;

/// Values are those of robots and sensors.
pub fn values_are_plausible(subject: &Subject, sink: &mut Sink) {
    let mut found = Odd { subject, sink };
    offsets(&mut found);
    noises(&mut found);
    pushes(&mut found);
    grounds(&mut found);
    speeds(&mut found);
    scales(&mut found);
    dampings(&mut found);
}

impl Odd<'_, '_> {
    /// The largest magnitude that a distribution gives: the deviation of a normal one about its mean.
    fn largest(&self, path: &str) -> Option<f64> {
        Some(match Sampled::<crate::spec::typed::units::One>::read(self.subject.value(path)?)? {
            Sampler::Normal([mean, deviation]) => mean.abs() + deviation.abs(),
            other => other.bounds().into_iter().map(f64::abs).fold(0.0, f64::max),
        })
    }
}

fn offsets(found: &mut Odd) {
    let subject = found.subject;
    for (path, _) in subject.randomizations().iter().filter(|(_, row)| row.is::<JointOffset>()) {
        let key = JointOffset::offset.below(path);
        let Some(most) = found.largest(&key).filter(|most| *most > OFFSET) else { continue };
        let message = format!(
            "`{path}` shifts the zero of joints by up to {} rad: no robot that moves is calibrated so badly",
            short(most)
        );
        found.warn(&key, message, "write an error of calibration, such as \"0.02 rad\"");
    }
}

fn noises(found: &mut Odd) {
    let subject = found.subject;
    for (path, _) in subject.terms::<Observations>().iter().filter(|(_, term)| term.is::<JointPosition>()) {
        let key = JointPosition::noise.below(path);
        let Some(most) = found.largest(&key).filter(|most| *most > NOISE) else { continue };
        let message = format!("`{path}` is lost in its noise of {} rad", short(most));
        found.warn(
            &key,
            message,
            "write the noise of an encoder, such as { normal = [\"0 rad\", \"1e-3 rad\"] }",
        );
    }
    let spreads = ["standing_noise", "position_noise"];
    let starts = spreads.map(|key| format!("{}.{key}", Initial::SECTION)).into_iter();
    let evaluated = subject.protocols().into_iter().map(|(path, _)| Spread::perturbation.below(&path));
    for key in starts.chain(evaluated) {
        let Some(most) = found.largest(&key).filter(|most| *most > START) else { continue };
        let message =
            format!("`{key}` starts episodes up to {} rad from the pose: a fallen robot", short(most));
        found.warn(&key, message, "write a small spread, such as \"0.05 rad\"");
    }
}

fn pushes(found: &mut Odd) {
    let subject = found.subject;
    let Some(mass) = subject.robot.map(|robot| robot.total_mass()) else { return };
    for (path, _) in subject.randomizations().iter().filter(|(_, row)| row.is::<Pushes>()) {
        let key = Pushes::impulse.below(path);
        let Some(most) = found.largest(&key) else { continue };
        if most <= 0.0 {
            found.warn(
                &key,
                format!("`{path}` has no effect: its impulse is 0"),
                "write an impulse such as \"20 N*s\", or remove the push",
            );
        } else if most > SHOVE * mass {
            let message = format!(
                "`{path}` throws the robot: {} N s change the velocity of its {} kg by {} m/s",
                short(most),
                short(mass),
                short(most / mass)
            );
            let help = format!("write an impulse such as \"{} N*s\"", short((0.5 * mass).round().max(1.0)));
            found.warn(&key, message, &help);
        }
    }
}

fn grounds(found: &mut Odd) {
    let subject = found.subject;
    for path in subject.grounds() {
        let Some(ground) = subject.section(&path) else { continue };
        let flat = [
            (ground.is::<BoxObstacle>(), BoxObstacle::height.below(&path), "the obstacle", "height"),
            (ground.is::<HeightField>(), HeightField::amplitude.below(&path), "the field", "amplitude"),
        ];
        for (_, key, what, noun) in flat.into_iter().filter(|(is, ..)| *is) {
            if subject.number(&key).is_some_and(|height| height <= 0.0) {
                let message = format!("{what} of `{path}` is flat ground: its {noun} is 0");
                found.warn(&key, message, "write a height, or `kind = \"flat\"`");
            }
        }
        if let Some(angle) = ground.value(Slope::angle).filter(|_| ground.is::<Slope>()) {
            let grip = subject
                .robot
                .map_or(1.0, |robot| robot.feet.iter().map(|foot| foot.friction).fold(0.0, f64::max));
            let friction = ground.value(Slope::friction).unwrap_or(f64::INFINITY) * grip;
            let slides = libm::tan(angle.abs()) >= friction || angle.abs() >= std::f64::consts::FRAC_PI_2;
            if slides && friction > 0.0 {
                let message = format!(
                    "a robot slides on `{path}`: a slope of {} deg needs a friction above {}, and it is {}",
                    short(angle.abs().to_degrees()),
                    short(libm::tan(angle.abs().min(1.57))),
                    short(friction)
                );
                found.warn(&Slope::angle.below(&path), message, "write a smaller angle or a larger friction");
            }
        }
    }
}

/// Randomizations that multiply by 1.
fn scales(found: &mut Odd) {
    let subject = found.subject;
    for (path, _) in subject.randomizations() {
        let key = format!("{path}.scale");
        let scale = subject.value(&key).and_then(Sampled::<crate::spec::typed::units::One>::read);
        let is_one = |scale: &Sampler| match scale {
            Sampler::Normal([mean, deviation]) => *mean == 1.0 && *deviation == 0.0,
            other => other.bounds() == [1.0, 1.0],
        };
        if scale.is_some_and(|scale| is_one(&scale)) {
            let message = format!("`{path}` has no effect: it multiplies by 1");
            found.warn(&key, message, "write a range such as { uniform = [0.8, 1.2] }, or remove the row");
        }
    }
}

/// The servos that give the labels of the pre-training are damped, by themselves or by their joints.
fn dampings(found: &mut Odd) {
    let subject = found.subject;
    let Some(robot) = subject.robot else { return };
    let key = format!("{}.damping", Pretraining::SECTION);
    let is_undamped = robot.links.iter().any(|link| link.joint.damping <= 0.0);
    if is_undamped && subject.number(&key).is_some_and(|damping| damping <= 0.0) {
        let message = format!("the labels of the pre-training swing: `{key}` is {}", subject.written(&key));
        found.warn(&key, message, "write a share of the robot's own derivative gain, such as \"50 %\"");
    }
}

/// No evaluation is far beyond the trained commands, unless the training has none.
fn speeds(found: &mut Odd) {
    let subject = found.subject;
    let Some(robot) = subject.robot else { return };
    let Some(command) = Task::commanded(subject.spec()) else { return };
    let [low, high] = command.speed.bounds();
    let most = low.abs().max(high.abs());
    if most <= 0.0 {
        return;
    }
    let fastest = (FASTEST * GRAVITY * hip_height(robot).max(1e-3)).sqrt();
    let mut asked: Vec<(String, f64)> = Vec::new();
    for (path, table) in subject.protocols() {
        let key = evaluate::Command::speed.below(&Episodes::command.below(&path));
        asked.extend(subject.number(&key).map(|speed| (key, speed)));
        if let Some(Evaluation::Speeds(speeds)) = Evaluation::of_section(table) {
            let listed = [Speeds::to.below(&path), "speeds".to_owned()];
            let key = listed.into_iter().find(|key| subject.value(key).is_some()).unwrap_or(path);
            let speed = speeds.grid().into_iter().reduce(|a, b| if b.abs() > a.abs() { b } else { a });
            asked.extend(speed.map(|speed| (key, speed)));
        }
    }
    for (key, speed) in asked {
        if speed.abs() <= BEYOND * most || speed.abs() > fastest {
            continue;
        }
        let trained = Command::speed.below(&Walk::command.path());
        let message = format!(
            "{} m/s is {} times the fastest trained command (`{trained}`, {} m/s)",
            short(speed),
            short((speed.abs() / most * 10.0).round() / 10.0),
            short(most)
        );
        found.warn(&key, message, "evaluate speeds that are trained, or train those that are evaluated");
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::{found, values};
    use super::*;
    use crate::robot::tests::robot;

    fn table(text: &str, sound: &[&str], odd: &[(&str, &str)]) {
        values(values_are_plausible, text, sound, odd);
    }

    #[test]
    fn offsets_and_noise_that_no_robot_has_are_told_wherever_they_are() {
        let shifts = "shifts the zero";
        for place in ["randomize", "evaluate.varied.randomize"] {
            let text = format!("[{place}.joint_offset]\nkind = \"joint_offset\"\noffset = {{}}");
            table(&text, &["[-0.05, 0.05]", "0.0"], &[("[-2.0, 2.0]", shifts), ("-1.0", shifts)]);
        }
        let text = "[observe.joint_position]\nkind = \"joint_position\"\nnoise = {}";
        table(text, &["[-0.01, 0.01]"], &[("[-1.0, 1.0]", "lost in its noise"), ("0.5", "lost")]);
        table("initial.standing_noise = {}", &["[-0.05, 0.05]"], &[("[-2.0, 2.0]", "a fallen robot")]);
        table("evaluate.a.perturbation = {}", &["0.01", "0.3"], &[("1.0", "a fallen robot")]);
    }

    #[test]
    fn pushes_without_an_impulse_or_beyond_any_robot_are_told() {
        for place in ["randomize", "evaluate.pushed.randomize"] {
            let text = format!("[{place}.push]\nkind = \"push\"\nduration = 0.1\nimpulse = {{}}");
            let odd = [("0.0", "has no effect"), ("40000.0", "throws the robot"), ("[0.0, 2e4]", "throws")];
            table(&text, &["20.0", "[0.0, 80.0]", "300.0"], &odd);
        }
    }

    #[test]
    fn grounds_without_a_height_or_too_steep_for_their_friction_are_told() {
        for place in ["terrain", "evaluate.course.terrain"] {
            let slope = format!("{place} = {{ kind = \"slope\", friction = 0.5, angle = {{}} }}");
            let slides = "a robot slides on";
            table(&slope, &["0.0", "0.2", "-0.4"], &[("0.6", slides), ("-0.7", slides), ("3.0", slides)]);
            let text = format!("{place} = {{ kind = \"box_obstacle\", friction = 1.0, height = {{}} }}");
            table(&text, &["0.01"], &[("0.0", "is flat ground")]);
            let text = format!("{place} = {{ kind = \"height_field\", friction = 1.0, amplitude = {{}} }}");
            table(&text, &["0.02"], &[("0.0", "is flat ground")]);
        }
    }

    #[test]
    fn randomizations_that_multiply_by_one_are_told() {
        for place in ["randomize", "evaluate.varied.randomize"] {
            let text = format!("[{place}.link_mass]\nkind = \"link_mass\"\nscale = {{}}");
            table(&text, &["[0.8, 1.2]", "1.1"], &[("1.0", "multiplies by 1"), ("[1.0, 1.0]", "by 1")]);
        }
    }

    #[test]
    fn undamped_labels_are_told_unless_every_joint_is_damped() {
        let text = "pretrain = { kind = \"tracking\", stiffness = 0.1, damping = 0.0 }";
        let mut robot = robot("tocabi");
        let told = |robot: &crate::robot::Robot, text: &str| {
            found(values_are_plausible, text, Some(robot)).into_iter().map(|found| found.message).collect()
        };
        robot.links[0].joint.damping = 0.0;
        let undamped: Vec<String> = told(&robot, text);
        assert!(undamped.len() == 1 && undamped[0].contains("labels of the pre-training swing"));
        assert_eq!(told(&robot, &text.replace("0.0 }", "0.2 }")), Vec::<String>::new());
        robot.links.iter_mut().for_each(|link| link.joint.damping = 1.0);
        assert_eq!(told(&robot, text), Vec::<String>::new());
    }

    #[test]
    fn evaluations_far_beyond_the_trained_commands_are_told() {
        let task = "task = { kind = \"walk\", motion = \"walk\", command = { speed = [0.0, 0.5] } }\n";
        let text = format!("{task}evaluate.fast = {{ kind = \"episodes\", command = {{ speed = {{}} }} }}");
        let odd = [("3.0", "6 times the fastest"), ("-2.0", "4 times the fastest")];
        table(&text, &["0.2", "0.5", "1.0", "-0.3", "9.9"], &odd);
        let still = text.replace("[0.0, 0.5]", "0.0");
        table(&still, &["3.0"], &[]);
    }
}
