//! Physical checks of a tree as read from its file, with places (E0405).

use nalgebra::Matrix3;

use super::tree::{Hinge, Part, Tree};
use crate::diag::{Diagnostic, Sink, Span};
use crate::robot::examine::{INERTIA, LENGTH, MASS};

/// A value that is impossible for rigid bodies or joints.
pub(super) fn impossible(message: String, span: Span) -> Diagnostic {
    Diagnostic::error("E0405", message).at(span, "")
}

/// Reports impossible values.
pub(super) fn check(tree: &Tree, sink: &mut Sink) {
    for part in &tree.parts {
        if let Some((message, help, span)) = beyond(part) {
            sink.emit(Diagnostic { code: "E0424", ..placed(message, span) }.help(help));
            continue;
        }
        for (message, help) in body(part) {
            sink.emit(placed(message, part.span).help(help));
        }
        for (message, help) in part.hinge.iter().filter(|hinge| hinge.other.is_none()).flat_map(joint) {
            sink.emit(placed(message, part.hinge.as_ref().and_then(|hinge| hinge.span)).help(help));
        }
    }
}

fn placed(message: String, span: Option<Span>) -> Diagnostic {
    match span {
        Some(span) => impossible(message, span),
        None => Diagnostic::error("E0405", message),
    }
}

/// Distance in m above which computations fail; those between [`LENGTH`] and this are reported when the robot
/// is written.
const FAR: f64 = 1e6;

/// A value of a body that no machine has and that makes computations fail: message, help and place.
fn beyond(part: &Part) -> Option<(String, &'static str, Option<Span>)> {
    let (name, mass, moment) = (&part.body.name, part.body.mass, part.body.inertia.amax());
    let far = |away: f64, what: String, span: Option<Span>| {
        let help = "write lengths in m: multiply those of a file in millimetres by 0.001";
        (away > FAR).then(|| (format!("{what} is {away:e} m away, more than {LENGTH} m"), help, span))
    };
    if mass > MASS {
        let message = format!("the mass of `{name}` is {mass:e} kg, more than {MASS:e} kg");
        return Some((message, "write it in kg", part.span));
    }
    if moment > INERTIA {
        let message = format!("the inertia of `{name}` is {moment:e} kg m^2, more than {INERTIA:e} kg m^2");
        return Some((message, "write moments of inertia about the centre of mass in kg m^2", part.span));
    }
    let joint = part.hinge.as_ref().and_then(|hinge| hinge.span).or(part.span);
    far(part.body.com.coords.amax(), format!("the centre of mass of `{name}`"), part.span)
        .or_else(|| far(part.pose.translation.vector.amax(), format!("`{name}`"), joint))
}

/// Only negative values are errors: a body of a file may be a point or a frame, and one that is welded may be
/// invalid on its own. Moving bodies are checked after welding.
fn body(part: &Part) -> Vec<(String, &'static str)> {
    let (name, mass) = (&part.body.name, part.body.mass);
    if mass < 0.0 {
        return vec![(format!("the mass of `{name}` is {mass} kg"), "a mass is positive")];
    }
    let fault = negative(moments(&part.body.inertia));
    fault.map(|fault| (format!("the inertia of `{name}` {fault}"), CURE)).into_iter().collect()
}

/// Help for an inertia that no rigid body can have.
pub(super) const CURE: &str = "no principal moment is negative, and none exceeds the sum of the other two: \
    mend the file, weld the body by leaving its joint out of --joints, or replace its moments by their mean \
    with --balance-inertia";

/// Principal moments, smallest first.
fn moments(tensor: &Matrix3<f64>) -> [f64; 3] {
    let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    moments
}

/// Rounding error of a moment: relative to the largest one, and at least that of 1 mg at 1 mm.
fn slack(high: f64) -> f64 {
    1e-6 * high.abs() + 1e-12
}

fn negative([low, _, high]: [f64; 3]) -> Option<String> {
    (low < -slack(high)).then(|| format!("has a negative principal moment, {low:.3e} kg m^2"))
}

/// What is wrong with the inertia of a body that may be a point or a rod.
pub(super) fn inertia(tensor: &Matrix3<f64>) -> Option<String> {
    let moments @ [low, middle, high] = moments(tensor);
    negative(moments).or_else(|| {
        (high > low + middle + slack(high)).then(|| {
            format!("violates the triangle inequality: {high:.3e} > {low:.3e} + {middle:.3e} kg m^2")
        })
    })
}

/// The tree with impossible moments of inertia replaced by their mean, as by MuJoCo's `balanceinertia`.
/// Without a positive mean they are unchanged.
pub(super) fn balanced(tree: &Tree) -> Tree {
    let mut tree = tree.clone();
    for part in &mut tree.parts {
        let mean = part.body.inertia.trace() / 3.0;
        if let Some(fault) = inertia(&part.body.inertia).filter(|_| mean > 0.0) {
            part.body.inertia = Matrix3::from_diagonal_element(mean);
            let name = &part.body.name;
            tree.notes.push(format!(
                "`{name}`: its inertia {fault}; its moments were replaced by their mean, {mean:.3e} kg m^2"
            ));
        }
    }
    tree
}

fn joint(hinge: &Hinge) -> Vec<(String, &'static str)> {
    let mut faults = Vec::new();
    let name = &hinge.name;
    if let (Some(lower), Some(upper)) = (hinge.lower, hinge.upper)
        && lower >= upper
    {
        let message = format!("the limits of joint `{name}` are not an interval: {lower} to {upper} rad");
        faults.push((message, "write the lower limit below the upper one"));
    }
    let figures = [
        ("effort limit", hinge.effort_limit),
        ("velocity limit", hinge.velocity_limit),
        ("damping", hinge.damping),
        ("friction", hinge.friction),
        ("armature", hinge.armature),
        ("proportional gain", hinge.stiffness_gain),
        ("derivative gain", hinge.damping_gain),
    ];
    for (what, value) in figures {
        if let Some(value) = value.filter(|value| *value < 0.0) {
            faults.push((format!("the {what} of joint `{name}` is {value}"), "it is not negative"));
        }
    }
    faults
}
