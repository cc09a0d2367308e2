//! Scales labels and exploration to a user's robot: relative to its weight, labels as soft and exploration as
//! strong as those with which every shipped robot squats and walks.
//!
//! Specs give both as shares of the figures in a robot's file, and files differ: relative to weight, G1's
//! gains are an eleventh of TOCABI's and its motors a third stronger. Torques are measured in units of the
//! torque that supports the robot's weight at the height of its pelvis, `m g h` in N m, times in units of
//! `sqrt(h / g)` in s, and each figure is the mean over the joints of the left leg
//! (`docs/experiments/2026-11-25-figures-for-the-weight.md`).

use crate::robot::{GRAVITY, Joint, Kinematics, Robot, hip_height, legs};

/// Stiffness of the labels in m g h per rad, and the damping of the labels and the joint together, in m g h
/// sqrt(h / g).
const LABELS: [(&str, [f64; 2]); 2] = [("walk", [0.16, 0.023]), ("run", [0.338, 0.0371])];
/// The labels of all other tasks.
const SOFT: [f64; 2] = [0.13, 0.023];
/// Stiffness of the servo with which robots train under position control, in m g h per rad: TOCABI, Atlas and
/// G1 have 0.22, 0.26 and 0.32.
const SERVO: f64 = 0.25;
/// Exploration under torque control, as a share of m g h: the paper's value; for runs TOCABI and Atlas have
/// 0.026 and 0.023.
const EXPLORATION: [(&str, f64); 2] = [("squat", 0.011), ("run", 0.025)];
/// The exploration of all other tasks.
const WALKS_WITH: f64 = 0.0172;
/// The exploration with which the profile `desk` trains a run; TOCABI and Atlas have 0.051 and 0.046.
const RUNS_WITH: f64 = 0.048;
/// The exploration in the last part of a walk and of a run.
const LAST_PARTS: [(&str, f64); 2] = [("walk", 0.0087), ("run", 0.012)];

/// Height of the base's origin divided by that of the hips' pitch axes: TOCABI, Atlas and G1, from which the
/// figures were derived, have 1.12, 1.06 and 1.15. A user's robot may have its base's origin anywhere, so the
/// height of its hips is used.
const PELVIS: f64 = 1.11;

/// The largest share that the keys allow.
const MOST: f64 = 10.0;

/// The smallest share that the keys of an exploration allow.
const LEAST: f64 = 1e-6;

/// Measures of a robot's legs and motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// The height of the pelvis above such legs, in m.
    pub stands: f64,
    /// The height of the base's origin in the default pose, in m.
    pub base: f64,
    /// Geometric mean of `stiffness_gain` in m g h per rad; `None` if a joint has none.
    pub stiffness: Option<f64>,
    /// Geometric mean of `damping_gain` in m g h sqrt(h / g); `None` if a joint has none.
    pub damping: Option<f64>,
    /// Mean of the joints' passive damping in m g h sqrt(h / g).
    pub own_damping: f64,
    /// Geometric mean of the effort limits as a share of m g h; `None` if a joint has none.
    pub effort: Option<f64>,
}

impl Build {
    /// The measures of a robot.
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

    /// Stiffness and damping of the labels as shares of the robot's own gains. Passive damping of the joints
    /// is subtracted.
    pub fn labels(&self, task: &str) -> Option<[String; 2]> {
        let [stiffness, damped] =
            LABELS.iter().find(|(known, _)| *known == task).map_or(SOFT, |(_, labels)| *labels);
        let damping = (damped - self.own_damping).max(0.0);
        Some([percent(stiffness / self.stiffness?), percent(damping / self.damping?)])
    }

    /// The stiffness of the servo for training, as a share of the robot's own gains.
    pub fn servo(&self) -> Option<String> {
        Some(percent(SERVO / self.stiffness?))
    }

    /// The exploration of a task as a share of the effort limits.
    pub fn exploration(&self, task: &str) -> Option<String> {
        let of = EXPLORATION.iter().find(|(known, _)| *known == task).map_or(WALKS_WITH, |(_, of)| *of);
        Some(noise(of / self.effort?))
    }

    /// The exploration with which the profile `desk` trains a run.
    pub fn running_exploration(&self) -> Option<String> {
        Some(noise(RUNS_WITH / self.effort?))
    }

    /// The exploration of a task's last part; `None` if it has none.
    pub fn last_exploration(&self, task: &str) -> Option<String> {
        let (_, of) = LAST_PARTS.iter().find(|(known, _)| *known == task)?;
        Some(noise(of / self.effort?))
    }
}

/// The share for an exploration, at least the smallest allowed one however strong the motors are.
fn noise(share: f64) -> String {
    percent(share.max(LEAST))
}

/// A share with two significant digits; `None` if it is below the smallest.
fn percent(share: f64) -> String {
    let percent = 100.0 * share.min(MOST);
    if percent < 99.0 * LEAST {
        return "0 %".to_owned();
    }
    let digits = (1.0 - libm::log10(percent).floor()).max(0.0) as usize;
    format!("{percent:.digits$} %")
}
