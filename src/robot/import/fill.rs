//! Joint parameters that the user supplies at the import because the source lacks them.

use std::fmt;

use regex_lite::Regex;

use super::tree::Hinge;
use super::welded::Welded;
use crate::quantity::parse::quantity;

/// A value for joints whose source lacks it.
#[derive(Clone, Debug)]
pub struct Fill {
    /// Pattern of joint names; all joints if absent.
    pub joints: Option<Regex>,
    /// The key: `damping`.
    pub key: String,
    /// The value with its unit: `0.1 N*m*s/rad`.
    pub value: String,
}

impl Fill {
    /// Whether it applies to this parameter of this joint.
    pub fn fits(&self, key: &str, joint: &str) -> bool {
        self.key == key && self.joints.as_ref().is_none_or(|joints| joints.is_match(joint))
    }
}

impl fmt::Display for Fill {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joints = self.joints.as_ref().map(|joints| format!("{joints}:")).unwrap_or_default();
        write!(formatter, "{joints}{}={}", self.key, self.value)
    }
}

/// Joint keys that a source may lack, with their units and meanings.
pub(super) const FIGURES: [(&str, &str, &str); 10] = [
    ("lower", "rad", "lower position limit"),
    ("upper", "rad", "upper position limit"),
    ("effort_limit", "N*m", "largest torque of the drive"),
    ("velocity_limit", "rad/s", "speed limit of the motor"),
    ("damping", "N*m*s/rad", "viscous damping"),
    ("friction", "N*m", "Coulomb friction"),
    ("armature", "kg*m^2", "reflected inertia of the rotor"),
    ("stiffness_gain", "N*m/rad", "proportional gain of position control"),
    ("damping_gain", "N*m*s/rad", "derivative gain of position control"),
    ("default_position", "rad", "position in the knee-bent standing pose"),
];

/// Joint keys that can be filled in at the import, with their units.
pub fn fillable() -> impl Iterator<Item = (&'static str, &'static str)> {
    FIGURES.iter().map(|(key, unit, _)| (*key, *unit))
}

/// The parameter that turns a joint into a motor.
pub(super) const LIMIT: &str = "effort_limit";

/// Whether a fill applies to a joint. A passive joint becomes a motor only if it is named explicitly: an
/// effort limit for all joints, or for a group that includes driven ones, applies only to the driven ones.
pub(super) fn gives<'a>(
    fill: &Fill,
    key: &str,
    hinge: &Hinge,
    mut kept: impl Iterator<Item = &'a Hinge>,
) -> bool {
    let mut is_named =
        || fill.joints.is_some() && kept.all(|other| other.passive || !fill.fits(key, &other.name));
    fill.fits(key, &hinge.name) && (key != LIMIT || !hinge.passive || is_named())
}

/// The value filled in for a key of a joint of this tree.
pub(super) fn filled<'a>(fills: &'a [Fill], hinge: &Hinge, key: &str, welded: &Welded) -> Option<&'a Fill> {
    fills.iter().rfind(|fill| gives(fill, key, hinge, welded.hinges()))
}

/// A joint parameter in SI units: from the file, or else filled in; `None` if missing in both.
pub(super) fn figure(
    key: &str,
    hinge: &Hinge,
    known: Option<f64>,
    fills: &[Fill],
    welded: &Welded,
) -> Option<f64> {
    known.or_else(|| quantity(&filled(fills, hinge, key, welded)?.value).ok().map(|filled| filled.si))
}
