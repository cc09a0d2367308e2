//! W0414, W0415 and E0425: limits that no motor has, and friction, damping and rotor inertia that the joint's
//! own motor cannot overcome.
//!
//! Robot descriptions written for a viewer have 1000 N m or 1000 rad/s as placeholders.

use std::f64::consts::TAU;

use super::scale::figure;
use super::size::{bodies, reach};
use super::{Examined, Outlier, worst};
use crate::robot::checks::Issue;
use crate::robot::kinematics::GRAVITY;
use crate::robot::model::{Joint, Robot};
use crate::spec::suggest::listed;

/// Maximum torque of a leg joint, relative to the robot's weight times its leg length; a squatting knee needs
/// about 0.5. TOCABI has 0.4, Atlas and G1 0.5.
const WEIGHTS: f64 = 5.0;
/// Speed limit in rad/s that no leg joint reaches; the fastest reach about 40.
const FASTEST: f64 = 100.0;
/// Range in rad that no leg joint has.
const TURN: f64 = TAU;
/// Speed in rad/s that every leg joint must reach against its own damping; slow walking needs 2.
const SLOWEST: f64 = 1.0;
/// Smallest velocity limit in rad/s of a leg joint that can step; the slowest known hip has 0.32.
const CREEPING: f64 = 0.25;
/// Share of the effort limit that friction leaves to a motor that can be used (E0425), and that it leaves in
/// known robots (W0415).
const LEFT: [f64; 2] = [0.2, 0.5];
/// Angular acceleration in rad/s^2 that every motor must give its own rotor; the swing of a slow step needs 10,
/// and the slowest known leg joint has 200.
const ACCELERATION: f64 = 15.0;
/// Smallest torque of a leg joint, relative to the robot's weight times its leg length; the weakest known toes
/// have 0.03.
const WEAKEST: f64 = 0.003;
/// Smallest range in rad of a leg joint; the stiffest ankles have 0.5.
const NARROW: f64 = 0.1;
/// Maximum number of joints listed by name; of the rest only the count is shown.
const NAMED: usize = 3;

/// Limits, friction and rotor inertias fit the robot.
pub fn check(robot: &Robot) -> Examined {
    let hold = holding(robot);
    let mut issues: Vec<Issue> = stuck(robot).into_iter().collect();
    issues.extend(placeholders(robot, hold));
    issues.extend(useless(robot, hold));
    issues.extend(rubbing(robot));
    issues.extend(slow(robot));
    issues.extend(heavy(robot));
    let share = robot.links.iter().map(|link| link.joint.effort_limit).fold(0.0, f64::max)
        / hold.unwrap_or(f64::INFINITY);
    Examined {
        name: "the drives fit the robot",
        detail: format!("the strongest joint carries {share:.2} times the weight at the length of the leg"),
        issues,
    }
}

fn joints(robot: &Robot) -> impl Iterator<Item = (usize, &Joint)> {
    robot.links.iter().enumerate().map(|(index, link)| (index, &link.joint))
}

/// The robot's weight times the length of its longer leg in N m; `None` if a mass is missing.
fn holding(robot: &Robot) -> Option<f64> {
    let length = robot.feet.iter().map(|foot| chain(robot, foot.link)).fold(0.0, f64::max);
    let known = bodies(robot).all(|(_, body)| body.mass > 0.0);
    (known && length > 0.0).then(|| robot.total_mass() * GRAVITY * length)
}

/// The length of the chain from the base to a link, in m.
fn chain(robot: &Robot, link: usize) -> f64 {
    let own = robot.links[link].joint.origin.translation.vector.norm();
    own + robot.links[link].parent.map_or(0.0, |parent| chain(robot, parent))
}

/// A limit of every joint, and what a message says of those that are wrong.
struct Limit<'a> {
    key: &'a str,
    of: &'a dyn Fn(&Joint) -> f64,
    /// The message, from the joints' names and the worst value.
    say: &'a dyn Fn(&str, f64) -> String,
    help: &'a str,
}

/// One issue for all joints whose limit is wrong (W0414), at the worst of them; `worse` compares two values.
fn wrong_limits(
    robot: &Robot,
    limit: &Limit,
    is_wrong: &dyn Fn(f64) -> bool,
    worse: fn(&f64, &f64) -> bool,
) -> Option<Issue> {
    let of = limit.of;
    let found: Vec<(usize, &Joint)> = joints(robot).filter(|(_, joint)| is_wrong(of(joint))).collect();
    let (index, worst) =
        found.iter().copied().reduce(|a, b| if worse(&of(b.1), &of(a.1)) { b } else { a })?;
    Some(Issue {
        code: "W0414",
        path: format!("links.{index}.joint.{}", limit.key),
        message: (limit.say)(&names(&found, robot.joints()), of(worst)),
        help: limit.help.to_owned(),
    })
}

/// One issue per type of limit that looks like a placeholder (W0414).
fn placeholders(robot: &Robot, hold: Option<f64>) -> Vec<Issue> {
    let told =
        |key: &str, of: &dyn Fn(&Joint) -> f64, most: f64, say: &dyn Fn(&str, f64) -> String, help: &str| {
            wrong_limits(robot, &Limit { key, of, say, help }, &|value| value > most, f64::gt)
        };
    let carried = hold.unwrap_or(f64::INFINITY);
    let issues = [
        told(
            "effort_limit",
            &|joint| joint.effort_limit,
            WEIGHTS * carried,
            &|names, most| {
                format!(
                    "the effort limit of {names}, up to {most:.0} N m, is more than {WEIGHTS:.0} times the \
                     robot's weight at \
                     the length of its leg ({carried:.1} N m): a placeholder?"
                )
            },
            "write the largest torque of the drive: torques are commanded as shares of it",
        ),
        told(
            "velocity_limit",
            &|joint| joint.velocity_limit,
            FASTEST,
            &|names, most| {
                format!(
                    "the velocity limit of {names}, up to {most:.0} rad/s, is beyond what legs move at: a \
                     placeholder?"
                )
            },
            "write the speed limit of the joint, at the output of its gear",
        ),
        told(
            "lower",
            &|joint| joint.upper - joint.lower,
            TURN,
            &|names, most| {
                format!("the range of {names}, up to {most:.1} rad, is more than a turn: a placeholder?")
            },
            "write the range that the joint may use: positions are commanded within it",
        ),
    ];
    issues.into_iter().flatten().collect()
}

fn names(found: &[(usize, &Joint)], joints: usize) -> String {
    let named = || found.iter().map(|(_, joint)| joint.name.as_str());
    match found.len() {
        count if count == joints && count > 1 => format!("all {count} joints"),
        count if count > NAMED + 1 => {
            let some: Vec<String> = named().take(NAMED).map(|name| format!("`{name}`")).collect();
            format!("{} and {} others", some.join(", "), count - NAMED)
        }
        _ => listed(named()),
    }
}

/// One issue per type of limit that is too small for a leg (W0414). Zeros are missing in the import.
fn useless(robot: &Robot, hold: Option<f64>) -> Vec<Issue> {
    let told =
        |key: &str, of: &dyn Fn(&Joint) -> f64, least: f64, say: &dyn Fn(&str, f64) -> String, help: &str| {
            wrong_limits(robot, &Limit { key, of, say, help }, &|value| value > 0.0 && value < least, f64::lt)
        };
    let carried = hold.unwrap_or(0.0);
    let issues = [
        told(
            "effort_limit",
            &|joint| joint.effort_limit,
            WEAKEST * carried,
            &|names, least| {
                format!(
                    "the effort limit of {names}, down to {} N m, is useless: the robot's weight at the \
                     length of its leg is {carried:.1} N m",
                    figure(least)
                )
            },
            "write the largest torque of the drive in N m: torques are commanded as shares of it",
        ),
        told(
            "velocity_limit",
            &|joint| joint.velocity_limit,
            CREEPING,
            &|names, least| {
                format!(
                    "the velocity limit of {names}, down to {} rad/s, is below that of a slow walk",
                    figure(least)
                )
            },
            "write the speed limit of the joint in rad/s, at the output of its gear",
        ),
        told(
            "lower",
            &|joint| joint.upper - joint.lower,
            NARROW,
            &|names, least| format!("the range of {names}, down to {least:.3} rad, is too small for a step"),
            "write the range that the joint may use in rad, or weld the joint: `specforge robot import --joints`",
        ),
    ];
    issues.into_iter().flatten().collect()
}

/// Joints that their motors cannot move, or only just (E0425). An effort limit of zero is missing in the
/// import.
fn stuck(robot: &Robot) -> Option<Issue> {
    worst(
        "E0425",
        held(robot, LEFT[0], f64::INFINITY),
        "joints",
        "write a Coulomb friction below 80 % of the effort limit: the rest must move the leg",
    )
}

/// Joints whose friction takes most of their motors' torque (W0415).
fn rubbing(robot: &Robot) -> Option<Issue> {
    let help =
        "write the Coulomb friction of the joint in N m: known joints have up to 5 % of their effort limit";
    worst("W0415", held(robot, LEFT[1], 1.0 - LEFT[0]), "joints", help)
}

/// Joints whose friction leaves at most this share of their torque, and takes less than `most` of it.
fn held(robot: &Robot, left: f64, most: f64) -> Vec<Outlier> {
    let share = |joint: &Joint| joint.friction / joint.effort_limit;
    let held = joints(robot)
        .filter(|(_, joint)| joint.effort_limit > 0.0 && share(joint) >= 1.0 - left && share(joint) < most);
    held.map(|(index, joint)| Outlier {
        excess: share(joint),
        path: format!("links.{index}.joint.friction"),
        message: format!(
            "the friction of joint `{}` is {} N m, and its motor has {} N m",
            joint.name,
            figure(joint.friction),
            figure(joint.effort_limit)
        ),
    })
    .collect()
}

/// Joints that are slowed down too much by their own damping (W0415).
fn slow(robot: &Robot) -> Option<Issue> {
    let left = |joint: &Joint| joint.effort_limit - joint.friction;
    let held = joints(robot).filter(|(_, joint)| left(joint) > 0.0 && joint.damping * SLOWEST > left(joint));
    let found = held.map(|(index, joint)| Outlier {
        excess: joint.damping / joint.effort_limit,
        path: format!("links.{index}.joint.damping"),
        message: format!(
            "the damping of joint `{}`, {} N m s/rad, takes all of its {} N m below {SLOWEST} rad/s",
            joint.name,
            figure(joint.damping),
            figure(left(joint))
        ),
    });
    let help =
        "write the viscous damping of the joint alone: the derivative gain of its servo is `damping_gain`";
    worst("W0415", found.collect(), "joints", help)
}

/// Rotors that their motors cannot accelerate as a step needs it, and those that exceed the robot's mass times
/// its size squared (W0415).
fn heavy(robot: &Robot) -> Option<Issue> {
    let reach = reach(robot);
    let whole = robot.total_mass() * reach * reach;
    let known = bodies(robot).all(|(_, body)| body.mass > 0.0);
    let found = joints(robot).filter_map(|(index, joint)| {
        let path = format!("links.{index}.joint.armature");
        let least = joint.effort_limit / ACCELERATION;
        if joint.effort_limit > 0.0 && joint.armature > least {
            let message = format!(
                "the motor of joint `{}` accelerates its own rotor ({} kg m^2) by at most {:.1} rad/s^2",
                joint.name,
                figure(joint.armature),
                joint.effort_limit / joint.armature
            );
            return Some(Outlier { excess: joint.armature / least, path, message });
        }
        (known && joint.armature > whole).then(|| Outlier {
            excess: joint.armature / whole,
            path,
            message: format!(
                "the armature of joint `{}`, {} kg m^2, is more than the whole robot's mass times its size \
                 squared ({whole:.3} kg m^2)",
                joint.name,
                figure(joint.armature)
            ),
        })
    });
    let help = "write the rotor's inertia times the square of the gear ratio in kg m^2";
    worst("W0415", found.collect(), "joints", help)
}
