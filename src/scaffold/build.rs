//! What a robot of one's own asks for: labels as soft and an exploration as strong for its weight as those by
//! which every robot that comes with the program squats and walks.
//!
//! Specs give both as shares of what a robot's file says, and files differ: for their weight G1's gains are
//! an eleventh of TOCABI's and its motors a third stronger. The measure of a torque is the one that holds the
//! robot's weight at the height at which its pelvis stands, `m g h` in N m, that of a time is `sqrt(h / g)`
//! in s, and each figure is the mean over the joints of the left leg
//! (`docs/experiments/2026-11-25-figures-for-the-weight.md`).

use crate::robot::{GRAVITY, Joint, Kinematics, Robot, hip_height, legs};

/// Stiffness of the labels in m g h per rad, and the damping of the labels and the joint's own together, in m
/// g h sqrt(h / g).
const LABELS: [(&str, [f64; 2]); 2] = [("walk", [0.16, 0.023]), ("run", [0.338, 0.0371])];
/// The labels of all other tasks.
const SOFT: [f64; 2] = [0.13, 0.023];
/// Stiffness of the servo with which robots learn to move under position control, in m g h per rad: TOCABI,
/// Atlas and G1 have 0.22, 0.26 and 0.32.
const SERVO: f64 = 0.25;
/// Exploration with torque, as a share of m g h; the paper's, with which runs of TOCABI and Atlas have 0.026
/// and 0.023.
const EXPLORATION: [(&str, f64); 2] = [("squat", 0.011), ("run", 0.025)];
/// The exploration of all other tasks.
const WALKS_WITH: f64 = 0.0172;
/// The exploration with which the desk learns a run, where TOCABI and Atlas have 0.051 and 0.046.
const RUNS_WITH: f64 = 0.048;
/// The exploration of the last part of a walk and of a run.
const LAST_PARTS: [(&str, f64); 2] = [("walk", 0.0087), ("run", 0.012)];

/// The height of the base's origin as a share of that of the hips' pitch axes: TOCABI, Atlas and G1, from
/// which the figures are, have 1.12, 1.06 and 1.15. Of a robot of one's own that origin may be anywhere, and
/// its hips are where they are.
const PELVIS: f64 = 1.11;

/// The largest share that the keys take.
const MOST: f64 = 10.0;

/// The smallest share that the keys of an exploration take.
const LEAST: f64 = 1e-6;

/// How a robot is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// The height of a pelvis over such legs, in m.
    pub stands: f64,
    /// The height at which the origin of its base stands, in m.
    pub base: f64,
    /// Geometric mean of `stiffness_gain` in m g h per rad; `None` where a joint has none.
    pub stiffness: Option<f64>,
    /// Geometric mean of `damping_gain` in m g h sqrt(h / g); `None` where a joint has none.
    pub damping: Option<f64>,
    /// Mean of the joints' own damping in m g h sqrt(h / g).
    pub own_damping: f64,
    /// Geometric mean of the effort limits as a share of m g h; `None` where a joint has none.
    pub effort: Option<f64>,
}

impl Build {
    /// That of a robot.
    pub fn of(robot: &Robot) -> Self {
        let stands = PELVIS * hip_height(robot);
        let torque = robot.total_mass() * GRAVITY * stands;
        let damping = torque * (stands / GRAVITY).sqrt();
        let leg = legs::own(&Kinematics::new(robot), 0);
        let joints = || leg.iter().map(|joint| &robot.links[*joint].joint);
        let count = leg.len() as f64;
        let mean = |figure: fn(&Joint) -> f64, unit: f64| {
            let sum: f64 = joints().map(|joint| libm::log(figure(joint))).sum();
            Some(libm::exp(sum / count) / unit).filter(|mean| mean.is_normal())
        };
        Self {
            stands,
            base: robot.standing_height,
            stiffness: mean(|joint| joint.stiffness_gain, torque),
            damping: mean(|joint| joint.damping_gain, damping),
            own_damping: joints().map(|joint| joint.damping).sum::<f64>() / count / damping,
            effort: mean(|joint| joint.effort_limit, torque),
        }
    }

    /// Labels' stiffness and damping as shares of the robot's own gains. What a joint damps by itself the
    /// labels need not.
    pub fn labels(&self, task: &str) -> Option<[String; 2]> {
        let [stiffness, damped] =
            LABELS.iter().find(|(known, _)| *known == task).map_or(SOFT, |(_, labels)| *labels);
        let damping = (damped - self.own_damping).max(0.0);
        Some([percent(stiffness / self.stiffness?), percent(damping / self.damping?)])
    }

    /// The stiffness of a servo with which it learns to move, as a share of the robot's own gains.
    pub fn servo(&self) -> Option<String> {
        Some(percent(SERVO / self.stiffness?))
    }

    /// The exploration of a task as a share of the effort limits.
    pub fn exploration(&self, task: &str) -> Option<String> {
        let of = EXPLORATION.iter().find(|(known, _)| *known == task).map_or(WALKS_WITH, |(_, of)| *of);
        Some(noise(of / self.effort?))
    }

    /// The exploration with which the desk learns a run.
    pub fn running_exploration(&self) -> Option<String> {
        Some(noise(RUNS_WITH / self.effort?))
    }

    /// The exploration of a task's last part; `None` where it has none.
    pub fn last_exploration(&self, task: &str) -> Option<String> {
        let (_, of) = LAST_PARTS.iter().find(|(known, _)| *known == task)?;
        Some(noise(of / self.effort?))
    }
}

/// The share of an exploration, which is not zero however strong the motors are.
fn noise(share: f64) -> String {
    percent(share.max(LEAST))
}

/// A share with two significant digits; what is less than the smallest is none.
fn percent(share: f64) -> String {
    let percent = 100.0 * share.min(MOST);
    if percent < 99.0 * LEAST {
        return "0 %".to_owned();
    }
    let digits = (1.0 - libm::log10(percent).floor()).max(0.0) as usize;
    format!("{percent:.digits$} %")
}
