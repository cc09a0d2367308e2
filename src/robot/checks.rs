//! Physical checks of a robot model: masses, inertias, limits, default pose. Independent of files.

use nalgebra::Matrix3;

use super::model::{Body, Joint, Robot, Shape};
use crate::diag::Severity;

/// Maximum number of joints of a robot.
pub const MOST_JOINTS: usize = 40;

/// Something wrong with a robot file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Issue {
    /// The diagnostic's code: E0403 to E0408 mean an invalid model, the others concern a valid one.
    pub code: &'static str,
    /// Where, as a path of keys and list indices from the top level of the file: `links.3.joint.lower`.
    pub path: String,
    /// One sentence, lower case, without a full stop.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl Issue {
    /// A violated physical check (E0405).
    pub fn model(path: impl Into<String>, message: impl Into<String>, help: &str) -> Self {
        Self { code: "E0405", path: path.into(), message: message.into(), help: help.to_owned() }
    }

    /// Error if the robot cannot be used, warning if it is only unusual.
    pub fn severity(&self) -> Severity {
        if self.code.starts_with('W') { Severity::Warning } else { Severity::Error }
    }
}

/// Whether the masses sum to the stated total within 0.1 g.
pub fn total_mass(robot: &Robot, stated: f64) -> Option<Issue> {
    let sum = robot.total_mass();
    ((sum - stated).abs() > 1e-4).then(|| {
        Issue::model(
            "total_mass",
            format!("the masses sum to {sum:.5} kg, not to the stated {stated:.5} kg"),
            "correct a mass or the total",
        )
    })
}

/// Whether the robot has too many joints.
pub fn size(joints: usize) -> Option<Issue> {
    (joints > MOST_JOINTS).then(|| Issue {
        code: "E0407",
        path: format!("links.{MOST_JOINTS}"),
        message: format!("the robot has {joints} joints, more than {MOST_JOINTS}"),
        help: "weld the joints that the experiment does not need; `specforge robot import --joints` does it"
            .to_owned(),
    })
}

/// All physical errors of a model.
pub fn model(robot: &Robot) -> Vec<Issue> {
    let mut issues = body("base", &robot.base);
    for (index, link) in robot.links.iter().enumerate() {
        issues.extend(body(&format!("links.{index}"), &link.body));
        issues.extend(joint(&format!("links.{index}.joint"), &link.joint));
    }
    if robot.links.is_empty() {
        issues.push(Issue::model("links", "the robot has no joint", "add at least one link"));
    }
    if robot.feet[0].link == robot.feet[1].link {
        issues.push(Issue::model(
            "feet",
            "both feet are the same link",
            "name the left and the right foot's link",
        ));
    }
    for (side, foot) in ["left", "right"].iter().zip(&robot.feet) {
        if !foot.half_extents.iter().all(|extent| *extent > 0.0) {
            let path = format!("feet.{side}.half_extents");
            issues.push(Issue::model(
                path,
                "the sole's box has no volume",
                "half extents are positive lengths",
            ));
        }
    }
    issues
}

/// Mass and inertia of a body.
fn body(path: &str, body: &Body) -> Vec<Issue> {
    let mut issues = Vec::new();
    let name = &body.name;
    if !(body.mass > 0.0 && body.mass.is_finite()) {
        let message = format!("the mass of `{name}` is {} kg", body.mass);
        issues.push(Issue::model(format!("{path}.mass"), message, "a mass is positive"));
    }
    if !body.com.iter().all(|x| x.is_finite()) {
        let message = format!("the centre of mass of `{name}` is not finite");
        issues.push(Issue::model(format!("{path}.com"), message, "write finite lengths"));
    }
    issues.extend(inertia(&body.inertia).map(|fault| {
        Issue::model(
            format!("{path}.inertia"),
            format!("the inertia of `{name}` {fault}"),
            "principal moments are positive and none exceeds the sum of the other two",
        )
    }));
    for (index, collision) in body.collisions.iter().enumerate() {
        if !positive(&collision.shape) {
            let message = format!("a collision shape of `{name}` has no volume");
            issues.push(Issue::model(
                format!("{path}.collisions.{index}"),
                message,
                "its lengths are positive",
            ));
        }
    }
    issues
}

/// Whether all lengths of a shape are positive; a capsule's length may be 0 (a sphere).
pub(super) fn positive(shape: &Shape) -> bool {
    match shape {
        Shape::Box(half) => half.iter().all(|half| *half > 0.0),
        Shape::Capsule(half, radius) => *half >= 0.0 && *radius > 0.0,
        Shape::Cylinder(half, radius) => *half > 0.0 && *radius > 0.0,
        Shape::Sphere(radius) => *radius > 0.0,
    }
}

/// What is wrong with an inertia tensor, if anything. The triangle inequality has a relative tolerance of
/// 1e-6 for rounded values.
pub(super) fn inertia(tensor: &Matrix3<f64>) -> Option<String> {
    if !tensor.iter().all(|x| x.is_finite()) {
        return Some("is not finite".to_owned());
    }
    let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let [low, middle, high] = moments;
    if low <= 0.0 {
        return Some(format!("is not positive definite: its smallest principal moment is {low:.3e} kg m^2"));
    }
    (high > (low + middle) * (1.0 + 1e-6))
        .then(|| format!("violates the triangle inequality: {high:.3e} > {low:.3e} + {middle:.3e} kg m^2"))
}

/// Limits, drive and default position of a joint.
pub(super) fn joint(path: &str, joint: &Joint) -> Vec<Issue> {
    let mut issues = Vec::new();
    let name = &joint.name;
    let mut fault = |key: &str, message: String, help: &str| {
        issues.push(Issue::model(format!("{path}.{key}"), message, help))
    };
    let ordered = joint.lower < joint.upper && joint.lower.is_finite() && joint.upper.is_finite();
    if !ordered {
        let message = format!(
            "the limits of joint `{name}` are not an interval: {} to {} rad",
            joint.lower, joint.upper
        );
        fault("lower", message, "write the lower limit below the upper one");
    }
    for (key, value) in [("effort_limit", joint.effort_limit), ("velocity_limit", joint.velocity_limit)] {
        if !(value > 0.0 && value.is_finite()) {
            fault(key, format!("`{key}` of joint `{name}` is {value}"), "a limit is positive and finite");
        }
    }
    let drive = [
        ("damping", joint.damping),
        ("friction", joint.friction),
        ("armature", joint.armature),
        ("stiffness_gain", joint.stiffness_gain),
        ("damping_gain", joint.damping_gain),
    ];
    for (key, value) in drive {
        if !(value >= 0.0 && value.is_finite()) {
            fault(key, format!("`{key}` of joint `{name}` is {value}"), "it is not negative, and finite");
        }
    }
    if ordered && !(joint.lower..=joint.upper).contains(&joint.default_position) {
        issues.push(Issue {
            code: "E0406",
            path: format!("{path}.default_position"),
            message: format!(
                "the default position of joint `{name}` is {} rad, outside its limits {} to {} rad",
                joint.default_position, joint.lower, joint.upper
            ),
            help: "choose a pose within the limits".to_owned(),
        });
    }
    issues
}
