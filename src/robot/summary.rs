//! Output of `robot show`: masses, limits, gains and the result of each check.

use serde::Serialize;

use super::checks::{self, Issue};
use super::examine::{self, Examined};
use super::kinematics::Kinematics;
use super::legs::leg_length;
use super::model::Robot;
use crate::diag::Severity;

/// The parameters of a robot, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The robot's name.
    pub name: String,
    /// Total mass in kg.
    pub total_mass: f64,
    /// Centre of mass in the default pose in the base frame, in m.
    pub com: [f64; 3],
    /// Height of the base origin above the ground in the default pose, in m.
    pub standing_height: f64,
    /// Distance from hip pitch joint to ankle with straight legs, in m; absent without pitch joints.
    pub leg_length: Option<f64>,
    /// The joints, in the order of all joint vectors.
    pub joints: Vec<JointSummary>,
    /// The base and the links.
    pub links: Vec<LinkSummary>,
    /// The checks.
    pub checks: Vec<Check>,
}

/// The parameters of a joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointSummary {
    /// Its name.
    pub name: String,
    /// Lower position limit in rad.
    pub lower: f64,
    /// Upper position limit in rad.
    pub upper: f64,
    /// Effort limit in N m.
    pub effort_limit: f64,
    /// Motor speed limit in rad/s.
    pub velocity_limit: f64,
    /// Viscous damping in N m s/rad.
    pub damping: f64,
    /// Coulomb friction in N m.
    pub friction: f64,
    /// Reflected rotor inertia in kg m^2.
    pub armature: f64,
    /// Proportional gain at 100 % stiffness in N m/rad.
    pub stiffness_gain: f64,
    /// Derivative gain at 100 % stiffness in N m s/rad.
    pub damping_gain: f64,
    /// Position in the default pose in rad.
    pub default_position: f64,
    /// Name of the joint on the other side.
    pub mirror: String,
    /// Sign of the mirrored coordinate.
    pub mirror_sign: f64,
}

/// The parameters of a body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkSummary {
    /// Its name.
    pub name: String,
    /// Name of its parent; absent for the base.
    pub parent: Option<String>,
    /// Mass in kg.
    pub mass: f64,
    /// Centre of mass in the body frame in m.
    pub com: [f64; 3],
    /// Principal moments of inertia in kg m^2, smallest first.
    pub principal_moments: [f64; 3],
    /// Number of collision shapes, including the box of a foot's sole.
    pub shapes: usize,
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The property that is checked.
    pub name: &'static str,
    /// Whether no error was found.
    pub passed: bool,
    /// The value that decided it, or the findings.
    pub detail: String,
    /// The findings.
    pub findings: Vec<Finding>,
}

/// An error or a warning of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// `error` or `warning`.
    pub severity: &'static str,
    /// Its code.
    pub code: &'static str,
    /// Where in the robot's file, as a path of keys and indices.
    pub path: String,
    /// What is wrong.
    pub message: String,
    /// How to fix it.
    pub help: String,
}

impl From<Issue> for Finding {
    fn from(issue: Issue) -> Self {
        let severity = match issue.severity() {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        let Issue { code, path, message, help } = issue;
        Self { severity, code, path, message, help }
    }
}

impl From<Examined> for Check {
    fn from(Examined { name, detail, issues }: Examined) -> Self {
        let passed = issues.iter().all(|issue| issue.severity() == Severity::Warning);
        let told =
            issues.iter().map(|issue| format!("[{}] {}", issue.code, issue.message)).collect::<Vec<_>>();
        let detail = if told.is_empty() { detail } else { told.join("; ") };
        Self { name, passed, detail, findings: issues.into_iter().map(Finding::from).collect() }
    }
}

/// The summary of a robot.
pub fn summary(robot: &Robot) -> Summary {
    Summary {
        name: robot.name.clone(),
        total_mass: robot.total_mass(),
        com: Kinematics::new(robot).com().into(),
        standing_height: robot.standing_height,
        leg_length: leg_length(robot),
        joints: (0..robot.joints()).map(|index| joint(robot, index)).collect(),
        links: (0..=robot.joints()).map(|index| link(robot, index)).collect(),
        checks: checks(robot),
    }
}

fn joint(robot: &Robot, index: usize) -> JointSummary {
    let joint = &robot.links[index].joint;
    let (image, mirror_sign) = robot.mirror[index];
    JointSummary {
        name: joint.name.clone(),
        lower: joint.lower,
        upper: joint.upper,
        effort_limit: joint.effort_limit,
        velocity_limit: joint.velocity_limit,
        damping: joint.damping,
        friction: joint.friction,
        armature: joint.armature,
        stiffness_gain: joint.stiffness_gain,
        damping_gain: joint.damping_gain,
        default_position: joint.default_position,
        mirror: robot.links[image].joint.name.clone(),
        mirror_sign,
    }
}

/// The base (0) or a link (index from 1).
fn link(robot: &Robot, index: usize) -> LinkSummary {
    let (body, parent) = match index.checked_sub(1) {
        None => (&robot.base, None),
        Some(index) => {
            let link = &robot.links[index];
            let parent = link.parent.map_or(&robot.base, |parent| &robot.links[parent].body);
            (&link.body, Some(parent.name.clone()))
        }
    };
    let mut moments: [f64; 3] = body.inertia.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let soles = robot.feet.iter().filter(|foot| foot.link + 1 == index).count();
    LinkSummary {
        name: body.name.clone(),
        parent,
        mass: body.mass,
        com: body.com.into(),
        principal_moments: moments,
        shapes: body.collisions.len() + soles,
    }
}

fn checks(robot: &Robot) -> Vec<Check> {
    let own = [
        Examined {
            name: "masses, inertias, limits and default pose are physical",
            detail: format!("{} bodies and {} joints", robot.joints() + 1, robot.joints()),
            issues: checks::model(robot),
        },
        Examined {
            name: "left and right mirror each other",
            detail: format!("centre of mass {:.1} mm off the middle", 1e3 * Kinematics::new(robot).com().y),
            issues: Vec::new(),
        },
    ];
    own.into_iter().chain(examine::all(robot)).map(Check::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{names, tests::robot};

    #[test]
    fn the_shipped_robots_pass_all_checks() {
        for name in names() {
            let summary = summary(&robot(name));
            assert!(
                summary.checks.iter().all(|check| check.findings.is_empty()),
                "{name}: {:#?}",
                summary.checks
            );
            assert!(
                (summary.links.iter().map(|link| link.mass).sum::<f64>() - summary.total_mass).abs() < 1e-9
            );
        }
    }

    #[test]
    fn the_summary_has_the_keys_of_the_contract() {
        let json = serde_json::to_value(summary(&robot("tocabi"))).unwrap();
        assert_eq!(json["name"], "tocabi");
        assert_eq!(json["total_mass"].as_f64().unwrap(), robot("tocabi").total_mass());
        assert_eq!(json["joints"][3]["effort_limit"], 289.0);
        assert_eq!(json["joints"][0]["mirror"], "R_HipYaw_Joint");
        assert_eq!(json["links"][0]["parent"], serde_json::Value::Null);
        assert_eq!(json["links"][6]["shapes"], 1, "a foot has its sole");
        assert_eq!(json["com"].as_array().unwrap().len(), 3);
    }
}
