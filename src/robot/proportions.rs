//! A robot's gains, damping and motors in units of its weight and height.
//!
//! Torques are measured in units of the torque that supports the robot's weight at the height of its pelvis,
//! `m g h` in N m, times in units of `sqrt(h / g)` in s, and each figure is a mean over the joints of the left
//! leg (`docs/experiments/2026-11-25-figures-for-the-weight.md`). Files differ in them: relative to weight,
//! G1's gains are an eleventh of TOCABI's and its motors a third stronger, so the same percentage of a robot's
//! own figures means different things.

use super::{GRAVITY, Joint, Kinematics, Robot, hip_height, legs};
use crate::quantity::{Measure, Relative};

/// Height of the base's origin divided by that of the hips' pitch axes: TOCABI, Atlas and G1, from which
/// recipes were derived, have 1.12, 1.06 and 1.15. A robot may have its base's origin anywhere, so the height
/// of its hips is used.
const PELVIS: f64 = 1.11;

/// A robot's figures relative to its weight and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportions {
    /// The height h of the pelvis above such legs, in m: 1.11 times that of the hips' pitch axes.
    pub stands: f64,
    /// The height of the base's origin in the default pose, in m.
    pub base: f64,
    /// m g h, in N m.
    pub torque: f64,
    /// Geometric mean of `stiffness_gain` in m g h per rad; `None` if a joint has none.
    pub stiffness: Option<f64>,
    /// Geometric mean of `damping_gain` in m g h sqrt(h / g) per rad; `None` if a joint has none.
    pub damping: Option<f64>,
    /// Mean of the joints' passive damping in m g h sqrt(h / g) per rad.
    pub own_damping: f64,
    /// Geometric mean of the effort limits as a share of m g h; `None` if a joint has none.
    pub effort: Option<f64>,
}

impl Proportions {
    /// The figures of a robot.
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
            torque,
            stiffness: mean(|joint| joint.stiffness_gain, torque),
            damping: mean(|joint| joint.damping_gain, damping),
            own_damping: joints().map(|joint| joint.damping).sum::<f64>() / count / damping,
            effort: mean(|joint| joint.effort_limit, torque),
        }
    }

    /// The share of the robot's own figures that a quantity amounts to; `None` if the robot lacks the figure.
    /// A damping includes the passive damping of the joints, which is subtracted, down to 0.
    pub fn share(&self, quantity: Relative) -> Option<f64> {
        let Relative { number, measure } = quantity;
        match measure {
            Measure::Torque => Some(number / self.effort?),
            Measure::Stiffness => Some(number / self.stiffness?),
            Measure::Damping => Some((number - self.own_damping).max(0.0) / self.damping?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: Proportions = Proportions {
        stands: 1.0,
        base: 1.0,
        torque: 1000.0,
        stiffness: Some(2.0),
        damping: Some(0.1),
        own_damping: 0.01,
        effort: Some(0.25),
    };

    #[test]
    fn a_share_is_relative_to_the_robots_own_figure_and_a_joint_keeps_its_own_damping() {
        let share = |number, measure| ROBOT.share(Relative { number, measure });
        assert_eq!(share(0.025, Measure::Torque), Some(0.1));
        assert_eq!(share(0.5, Measure::Stiffness), Some(0.25));
        assert!((share(0.03, Measure::Damping).unwrap() - 0.2).abs() < 1e-12);
        assert_eq!(share(0.005, Measure::Damping), Some(0.0));
        let limp = Proportions { stiffness: None, ..ROBOT };
        assert_eq!(limp.share(Relative { number: 0.5, measure: Measure::Stiffness }), None);
    }

    #[test]
    fn the_torque_unit_is_the_weight_at_the_height_of_the_pelvis() {
        let robot = crate::robot::shipped("tocabi").expect("it comes with the program");
        let own = Proportions::of(&robot);
        assert!((own.torque - robot.total_mass() * GRAVITY * own.stands).abs() < 1e-9);
        assert!((own.stands / robot.standing_height - 1.0).abs() < 0.05, "{own:?}");
    }
}
