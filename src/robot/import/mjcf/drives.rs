//! `<actuator>`, `<keyframe>` and `<custom>`: what a file says of the drives of joints.

use std::collections::BTreeMap;

use super::super::intake::Intake;
use super::super::tree::Hinge;
use super::super::xml::Element;
use super::defaults::Defaults;
use super::settings::Settings;

/// The actuators by joint, the first key frame, and named numbers.
#[derive(Debug, Default)]
pub(super) struct Drives {
    actuators: BTreeMap<String, Vec<Actuator>>,
    /// Its name and positions.
    key: Option<(String, Vec<f64>)>,
    numbers: BTreeMap<String, f64>,
}

/// An actuator as it acts on its joint.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    /// Largest torque in N m.
    effort: Option<f64>,
    /// Proportional gain in N m/rad.
    stiffness: Option<f64>,
    /// Derivative gain in N m s/rad.
    damping: Option<f64>,
}

impl Drives {
    /// The drives of a file.
    pub fn read(root: &Element, settings: &Settings, defaults: &Defaults, intake: &mut Intake) -> Self {
        let mut drives = Self::default();
        for element in root.all("actuator").flat_map(|actuators| &actuators.children) {
            let element = defaults.complete(element, None, intake);
            let Some(joint) = element.text("joint").or(element.text("jointinparent")) else { continue };
            let joint = joint.to_owned();
            let actuator = actuator(&element, settings, intake);
            drives.actuators.entry(joint).or_default().push(actuator);
        }
        let mut keys = root.all("keyframe").flat_map(|frames| frames.all("key"));
        if let Some(key) = keys.find(|key| key.attribute("qpos").is_some())
            && let Some(positions) = intake.numbers(key, "qpos")
        {
            drives.key = Some((key.text("name").unwrap_or("0").to_owned(), positions));
        }
        for number in root.all("custom").flat_map(|custom| custom.all("numeric")) {
            // Other programs' numbers may be lists; a figure of a joint is one number.
            if let (Some(name), Some(&[value])) = (number.text("name"), intake.numbers(number, "data").as_deref()) {
                drives.numbers.insert(name.to_owned(), value);
            }
        }
        drives
    }

    /// The name of the key frame that gives the default pose.
    pub fn key(&self) -> Option<&str> {
        self.key.as_ref().map(|(name, _)| name.as_str())
    }

    /// Writes what drives a joint into it; `address` is its place in the positions of a key frame, `own` the limits
    /// that the joint itself sets on its torque.
    pub fn equip(&self, hinge: &mut Hinge, address: usize, own: Option<f64>, intake: &mut Intake) {
        let actuators = self.actuators.get(&hinge.name).map_or(&[][..], Vec::as_slice);
        let effort = match actuators {
            [] => None,
            [actuator] => actuator.effort,
            [_, ..] => {
                intake.note(format!("joint `{}` has {} actuators", hinge.name, actuators.len()));
                None
            }
        };
        hinge.effort_limit = [effort, own].into_iter().flatten().reduce(f64::min);
        hinge.stiffness_gain = actuators.iter().find_map(|actuator| actuator.stiffness);
        hinge.damping_gain = actuators.iter().find_map(|actuator| actuator.damping);
        hinge.default_position = self.key.as_ref().and_then(|(_, positions)| positions.get(address).copied());
        for (key, figure) in [
            ("velocity_limit", &mut hinge.velocity_limit),
            ("stiffness_gain", &mut hinge.stiffness_gain),
            ("damping_gain", &mut hinge.damping_gain),
        ] {
            *figure = self.numbers.get(&format!("{}.{key}", hinge.name)).copied().or(*figure);
        }
    }
}

/// The smaller bound of a range that limits, or `None`.
pub(super) fn bound(
    range: &str,
    limited: &str,
    (element, settings): (&Element, &Settings),
    intake: &mut Intake,
) -> Option<f64> {
    let [low, high] = limits(range, limited, (element, settings), intake)?;
    let bound = low.abs().min(high.abs());
    if bound > 0.0 && (low + high).abs() > 1e-9 * high.abs() {
        intake.note(format!("<{}> is limited to {low} .. {high}; the smaller bound is taken for both", element.name));
    }
    (bound > 0.0).then_some(bound)
}

/// A range that limits.
pub(super) fn limits(
    range: &str,
    limited: &str,
    (element, settings): (&Element, &Settings),
    intake: &mut Intake,
) -> Option<[f64; 2]> {
    let range: [f64; 2] = intake.vector(element, range)?;
    match element.text(limited) {
        Some("true") => Some(range),
        Some("false") => None,
        _ => (settings.autolimits && range[0] < range[1]).then_some(range),
    }
}

fn actuator(element: &Element, settings: &Settings, intake: &mut Intake) -> Actuator {
    let gear = intake.numbers(element, "gear").and_then(|gear| gear.first().copied()).unwrap_or(1.0).abs();
    let force = bound("forcerange", "forcelimited", (element, settings), intake);
    let control = bound("ctrlrange", "ctrllimited", (element, settings), intake);
    let mut first = |key: &str, at: usize| intake.numbers(element, key).and_then(|list| list.get(at).copied());
    let (gain, back, brake) = (first("gainprm", 0), first("biasprm", 1), first("biasprm", 2));
    let affine = element.text("biastype") == Some("affine");
    let gear_squared = gear * gear;
    let servo = |stiffness: Option<f64>, damping: Option<f64>| Actuator {
        effort: force.map(|force| gear * force),
        stiffness: stiffness.map(|gain| gain * gear_squared),
        damping: damping.map(|gain| gain * gear_squared),
    };
    let driven = |gain: f64| {
        let commanded = control.map(|control| control * gain.abs());
        let effort = [force, commanded].into_iter().flatten().reduce(f64::min);
        Actuator { effort: effort.map(|effort| gear * effort), ..Actuator::default() }
    };
    match element.name.as_str() {
        "motor" => driven(1.0),
        "position" => {
            let stiffness = intake.number(element, "kp").unwrap_or(1.0);
            // A damping ratio needs the inertia that the servo sees, so the gain is left to be filled in.
            let damping = if element.attribute("dampratio").is_some() {
                None
            } else {
                Some(intake.number(element, "kv").unwrap_or(0.0))
            };
            servo(Some(stiffness), damping)
        }
        "velocity" => servo(None, Some(intake.number(element, "kv").unwrap_or(1.0))),
        "general" if affine => servo(back.map(|back| -back), brake.map(|brake| -brake)),
        "general" if element.text("dyntype").is_none_or(|kind| kind == "none") => driven(gain.unwrap_or(1.0)),
        _ => servo(None, None),
    }
}
