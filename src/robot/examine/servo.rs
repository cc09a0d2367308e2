//! W0424: position servos that are too soft to move their joints or to hold the robot at 100 % stiffness, or so
//! stiff that they only switch between their limits.
//!
//! Torque control does not use them, so this is not an error; a spec that does has its own check.

use nalgebra::Isometry3;

use super::scale::figure;
use super::{Examined, Outlier, worst};
use crate::robot::checks::Issue;
use crate::robot::gravity::{GravityCompensation, Weighting};
use crate::robot::model::{Joint, Robot};

/// The code of these findings.
pub const CODE: &str = "W0424";

/// Share of the effort limit that a servo must be able to command: less is lost in friction and rounding.
const LEAST: f64 = 0.01;

/// Share of the torque of the default pose that a servo must be able to command: leaning reduces the rest.
const HOLDING: f64 = 0.25;

/// Position error in rad and velocity in rad/s below which no servo may reach its effort limit: encoders and
/// their filters are not better. Known servos reach it at 0.04 rad and 4 rad/s.
const SWITCHING: [f64; 2] = [1e-3, 0.05];

/// Relative error of computed torques: a servo that is exactly at a limit is not reported.
const ROUNDING: f64 = 1e-6;

/// A joint whose position servo commands too little torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Weak {
    /// Index of the joint.
    pub joint: usize,
    /// Maximum torque in N m commanded in the default pose by a target within the joint's range.
    pub most: f64,
    /// The required torque in N m.
    pub needed: f64,
    /// The torque in N m that holds the default pose.
    standing: f64,
}

/// The joints whose servos are too soft at this share of the robot's own stiffness, with targets within the
/// joint limits. An effort limit of zero is missing in an import.
pub fn weak(robot: &Robot, stiffness: f64) -> Vec<Weak> {
    let most = |joint: &Joint| {
        let Joint { lower, upper, default_position, .. } = joint;
        stiffness * joint.stiffness_gain * (upper - default_position).max(default_position - lower)
    };
    let mut gravity = GravityCompensation::new(robot, Weighting::EffortLimits);
    let balance = gravity.hold(&Isometry3::identity(), &robot.default_pose(), [true; 2]);
    let joints = robot.links.iter().map(|link| &link.joint).enumerate().zip(&balance.torque);
    let too_soft = joints.filter_map(|((index, joint), torque)| {
        let standing = torque.abs();
        let needed = (HOLDING * standing).min(joint.effort_limit).max(LEAST * joint.effort_limit);
        let most = most(joint);
        let known = joint.effort_limit > 0.0 && needed.is_finite();
        (known && most < needed * (1.0 - ROUNDING)).then_some(Weak { joint: index, most, needed, standing })
    });
    too_soft.collect()
}

impl Weak {
    /// The problem of the servo: a clause after the joint's name.
    pub fn in_words(&self, robot: &Robot) -> String {
        let limit = robot.links[self.joint].joint.effort_limit;
        let (most, standing) = (short(self.most), short(self.standing));
        if self.standing > self.most {
            return format!(
                "commands at most {most} N m within the joint's range, and standing takes {standing} N m"
            );
        }
        format!(
            "commands at most {most} N m within the joint's range, and the motor has {} N m",
            figure(limit)
        )
    }
}

/// The servos move their joints and can hold the default pose.
pub fn check(robot: &Robot) -> Examined {
    let weak = weak(robot, 1.0);
    let names = |joint: usize| robot.links[joint].joint.name.as_str();
    let found = weak.iter().map(|weak| {
        let gain = robot.links[weak.joint].joint.stiffness_gain;
        let reason = if gain > 0.0 {
            format!("the position servo of joint `{}` {}", names(weak.joint), weak.in_words(robot))
        } else {
            format!("`stiffness_gain` of joint `{}` is 0: position actions cannot move it", names(weak.joint))
        };
        Outlier {
            excess: weak.needed / weak.most.max(1e-300),
            path: format!("links.{}.joint.stiffness_gain", weak.joint),
            message: reason,
        }
    });
    let help = "write the proportional gain of the joint's servo in N m/rad, or train with torque actions \
     alone and allow this warning with \
                the reason";
    let mut issues: Vec<_> = worst(CODE, found.collect(), "joints", help).into_iter().collect();
    issues.extend(switching(robot));
    let gains = robot.links.iter().map(|link| link.joint.stiffness_gain);
    Examined {
        name: "the position servos can hold the robot",
        detail: format!("the softest has {} N m/rad", short(gains.fold(f64::INFINITY, f64::min))),
        issues,
    }
}

/// Servos that reach their effort limit at errors which encoders do not resolve. An effort limit of zero is
/// missing in an import.
fn switching(robot: &Robot) -> Option<Issue> {
    let [angle, speed] = SWITCHING;
    let joints = robot.links.iter().map(|link| &link.joint).enumerate();
    let found = joints.filter(|(_, joint)| joint.effort_limit > 0.0).flat_map(|(index, joint)| {
        let gains = [
            ("stiffness_gain", joint.stiffness_gain, angle, "an error", "rad"),
            ("damping_gain", joint.damping_gain, speed, "a velocity", "rad/s"),
        ];
        gains.into_iter().filter_map(move |(key, gain, least, of, unit)| {
            let full = joint.effort_limit / gain;
            (full < least * (1.0 - ROUNDING)).then(|| Outlier {
                excess: least / full,
                path: format!("links.{index}.joint.{key}"),
                message: format!(
                    "the position servo of joint `{}` only switches: it reaches its {} N m at {of} of {full:.1e} \
                     {unit}",
                    joint.name,
                    figure(joint.effort_limit)
                ),
            })
        })
    });
    let help = "write the gains of the joint's servo in N m/rad and N m s/rad, at the output of its gear";
    worst(CODE, found.collect(), "gains", help)
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value) {
        let digits = 2 - libm::floor(libm::log10(value.max(1e-3))) as i32;
        let text = format!("{value:.*}", digits.clamp(0, 6) as usize);
        return if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
    }
    format!("{value:.2e}")
}
