//! `<actuator>`, `<keyframe>` and `<custom>`: the drives of joints.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, UnitQuaternion};

use super::super::intake::{Intake, no_key, value};
use super::super::tree::Hinge;
use super::super::xml::Element;
use super::defaults::Defaults;
use super::settings::Settings;
use crate::diag::Span;

/// The actuators by joint, a key frame, and named numbers.
#[derive(Debug, Default)]
pub(super) struct Drives {
    actuators: BTreeMap<String, Vec<Actuator>>,
    /// The key frame for the default pose.
    key: Option<Key>,
    /// Names of the other key frames.
    other_keys: Vec<String>,
    numbers: BTreeMap<String, f64>,
}

/// A key frame.
#[derive(Clone, Debug)]
struct Key {
    name: String,
    /// Generalized positions.
    positions: Vec<f64>,
    span: Span,
    /// Place of the positions.
    place: Span,
}

/// The effect of an actuator on its joint.
#[derive(Clone, Copy, Debug, Default)]
struct Actuator {
    /// Maximum torque in N m.
    effort: Option<f64>,
    /// Inertia in kg m^2 that it adds to the joint's.
    armature: f64,
    /// Additional passive damping in N m s/rad.
    passive: f64,
    servo: Servo,
}

/// What a servo adds to the gains of a joint.
#[derive(Clone, Copy, Debug, Default)]
struct Servo {
    /// Proportional gain in N m/rad.
    stiffness: Option<f64>,
    /// Derivative gain in N m s/rad.
    damping: Option<f64>,
    /// Damping ratio instead of a derivative gain.
    ratio: Option<f64>,
}

/// A servo with a damping ratio, whose gain depends on masses not yet known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio {
    /// Proportional gain in N m/rad.
    pub stiffness: f64,
    /// Damping relative to critical damping.
    pub ratio: f64,
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
        drives.take_key(root, intake);
        for number in root.all("custom").flat_map(|custom| custom.all("numeric")) {
            // Numbers of other programs may be lists; a joint parameter is one number.
            if let (Some(name), Some(&[value])) =
                (number.text("name"), intake.numbers(number, "data").as_deref())
            {
                drives.numbers.insert(name.to_owned(), value);
            }
        }
        drives
    }

    /// Selects the key frame requested, otherwise the first one with positions.
    fn take_key(&mut self, root: &Element, intake: &mut Intake) {
        let mut keys = Vec::new();
        for (index, key) in root.all("keyframe").flat_map(|frames| frames.all("key")).enumerate() {
            if let Some(positions) = key.attribute("qpos").and_then(|_| intake.numbers(key, "qpos")) {
                let name = key.text("name").map_or_else(|| index.to_string(), str::to_owned);
                keys.push(Key { name, positions, span: key.span, place: key.place("qpos") });
            }
        }
        let wanted = match &intake.key {
            Some(wanted) => {
                let Some(found) = keys.iter().position(|key| key.name == *wanted) else {
                    let names = keys.iter().map(|key| key.name.as_str()).collect::<Vec<_>>();
                    intake.tell(no_key(wanted, &names));
                    return;
                };
                found
            }
            None => 0,
        };
        if wanted < keys.len() {
            self.key = Some(keys.remove(wanted));
            self.other_keys = keys.into_iter().map(|key| key.name).collect();
        }
    }

    /// The names of the key frame for the default pose, and of the others.
    pub fn keys(&self) -> Option<(&str, &[String])> {
        self.key.as_ref().map(|key| (key.name.as_str(), self.other_keys.as_slice()))
    }

    /// Reports a key frame whose number of positions differs from the file's.
    pub fn measure(&self, positions: usize, intake: &mut Intake) {
        let Some(key) = self.key.as_ref().filter(|key| key.positions.len() != positions) else { return };
        let message = format!(
            "`qpos` of the key frame `{}` has {} numbers, and the file has {positions} positions",
            key.name,
            key.positions.len()
        );
        intake.tell(value(message, key.place).help(
            "write 7 numbers for a free joint (place and quaternion w x y z) and one for each hinge or \
             slide, in the order of the \
             file, or take another key frame with --key",
        ));
    }

    /// The orientation in the key frame of a floating base whose positions start at `address`.
    pub fn attitude(&self, address: usize, intake: &mut Intake) -> Option<UnitQuaternion<f64>> {
        let key = self.key.as_ref()?;
        let &[w, x, y, z] = key.positions.get(address + 3..address + 7)? else { return None };
        let attitude = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6);
        if attitude.is_none() {
            let message =
                format!("the orientation of the base in the key frame `{}` is not a quaternion", key.name);
            intake.tell(
                value(message, key.span).help("write w x y z with a length of 1 behind the base's place"),
            );
        }
        attitude
    }

    /// Adds the drives of a joint to it; `address` is its index in the positions of a key frame, `own` the
    /// joint's own torque limits. Returns the servos with a damping ratio.
    pub fn equip(
        &self,
        hinge: &mut Hinge,
        address: usize,
        own: Option<f64>,
        intake: &mut Intake,
    ) -> Vec<Ratio> {
        let actuators = self.actuators.get(&hinge.name).map_or(&[][..], Vec::as_slice);
        let effort = match actuators {
            [] => None,
            [actuator] => actuator.effort,
            [_, ..] => {
                intake.note(format!(
                    "joint `{}` has {} actuators: its effort limit is not taken from them",
                    hinge.name,
                    actuators.len()
                ));
                None
            }
        };
        hinge.passive = actuators.is_empty() && !self.actuators.is_empty();
        // A motor with zero gear or gain has no effect: its limit counts as unknown.
        hinge.zeros.extend(actuators.iter().any(|actuator| actuator.effort == Some(0.0)).then_some("effort"));
        hinge.effort_limit =
            [effort, own].into_iter().flatten().filter(|effort| *effort > 0.0).reduce(f64::min);
        let sum = |part: fn(&Actuator) -> Option<f64>| actuators.iter().filter_map(part).reduce(|a, b| a + b);
        let added = |part: fn(&Actuator) -> f64| actuators.iter().map(part).sum::<f64>();
        hinge.stiffness_gain = sum(|actuator| actuator.servo.stiffness);
        hinge.damping_gain = sum(|actuator| actuator.servo.damping);
        hinge.armature = hinge.armature.map(|own| own + added(|actuator| actuator.armature));
        hinge.damping = hinge.damping.map(|own| own + added(|actuator| actuator.passive));
        hinge.default_position = self.key.as_ref().and_then(|key| key.positions.get(address).copied());
        let number = |name: &str, key: &str| self.numbers.get(&format!("{name}.{key}")).copied();
        let is_open = number(&hinge.name, "damping_gain").is_none();
        for (key, figure) in [
            ("velocity_limit", &mut hinge.velocity_limit),
            ("stiffness_gain", &mut hinge.stiffness_gain),
            ("damping_gain", &mut hinge.damping_gain),
        ] {
            *figure = number(&hinge.name, key).or(*figure);
        }
        let ratio = |actuator: &Actuator| {
            let Servo { stiffness, ratio, .. } = actuator.servo;
            Some(Ratio { stiffness: stiffness?, ratio: ratio? })
        };
        actuators.iter().filter(|_| is_open).filter_map(ratio).collect()
    }
}

/// The smaller bound of an active limit, or `None`.
pub(super) fn bound(
    range: &str,
    limited: &str,
    element: &Element,
    settings: &Settings,
    intake: &mut Intake,
) -> Option<f64> {
    let [low, high] = limits(range, limited, element, settings, intake)?;
    let bound = low.abs().min(high.abs());
    if bound > 0.0 && (low + high).abs() > 1e-9 * high.abs() {
        intake.note(format!(
            "<{}> is limited to {low} .. {high}; the smaller bound is taken for both",
            element.name
        ));
    }
    (bound > 0.0).then_some(bound)
}

/// A range, if its limit is active.
pub(super) fn limits(
    range: &str,
    limited: &str,
    element: &Element,
    settings: &Settings,
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
    let gear_squared = gear * gear;
    let force = bound("forcerange", "forcelimited", element, settings, intake);
    let passive = intake.numbers(element, "damping").unwrap_or_default();
    if passive.iter().skip(1).any(|number| *number != 0.0) {
        intake.note(format!("<{}>: of its damping only the linear part is taken", element.name));
    }
    let law = law(element, intake);
    // A servo's control is a position or speed, whose range does not limit torque.
    let commanded = law
        .gain
        .and_then(|gain| Some(bound("ctrlrange", "ctrllimited", element, settings, intake)? * gain.abs()));
    let effort = [force, commanded].into_iter().flatten().reduce(f64::min);
    let effort = if gear == 0.0 { Some(0.0) } else { effort };
    let Servo { stiffness, damping, ratio } = if gear == 0.0 { Servo::default() } else { law.servo };
    Actuator {
        effort: effort.map(|effort| gear * effort),
        armature: gear_squared * intake.number(element, "armature").unwrap_or(0.0),
        passive: gear_squared * passive.first().copied().unwrap_or(0.0),
        servo: Servo {
            stiffness: stiffness.map(|gain| gain * gear_squared),
            damping: damping.map(|gain| gain * gear_squared),
            ratio,
        },
    }
}

/// How an actuator computes its force.
#[derive(Clone, Copy, Debug, Default)]
struct Law {
    /// Force per control of a motor.
    gain: Option<f64>,
    /// Servo gains before the gear.
    servo: Servo,
}

fn law(element: &Element, intake: &mut Intake) -> Law {
    match element.name.as_str() {
        "motor" => Law { gain: Some(1.0), ..Law::default() },
        "position" | "intvelocity" | "pid" => {
            let absent = if element.name == "pid" { 0.0 } else { 1.0 };
            let stiffness = intake.number(element, "kp").unwrap_or(absent);
            let ratio = intake.number(element, "dampratio");
            let damping = intake.number(element, "kv").unwrap_or(0.0);
            Law {
                gain: None,
                servo: Servo {
                    stiffness: Some(stiffness),
                    damping: ratio.is_none().then_some(damping),
                    ratio,
                },
            }
        }
        "velocity" => {
            let damping = intake.number(element, "kv").unwrap_or(1.0);
            Law { gain: None, servo: Servo { damping: Some(damping), ..Servo::default() } }
        }
        "general" => general(element, intake),
        _ => Law::default(),
    }
}

/// The force law of a `general` actuator: `gainprm` times the control plus, if affine, `biasprm` times (1,
/// position, speed).
fn general(element: &Element, intake: &mut Intake) -> Law {
    let is = |key: &str, kind: &str| element.text(key).is_none_or(|word| word == kind);
    let mut prm = |key: &str| intake.numbers(element, key).unwrap_or_default();
    let (gain, bias) = (prm("gainprm").first().copied().unwrap_or(1.0), prm("biasprm"));
    if !is("gaintype", "fixed") {
        return Law::default();
    }
    if element.text("biastype") != Some("affine") {
        let is_motor = is("dyntype", "none") && is("biastype", "none");
        return Law { gain: is_motor.then_some(gain), ..Law::default() };
    }
    let coefficient = |at: usize| bias.get(at).copied().unwrap_or(0.0);
    let (stiffness, damping) = (-coefficient(1), -coefficient(2));
    // MuJoCo interprets a positive third number of a position servo as a damping ratio.
    let ratio = (damping < 0.0 && stiffness == gain).then_some(-damping);
    let servo = Servo {
        stiffness: (stiffness != 0.0).then_some(stiffness),
        damping: ratio.is_none().then_some(damping),
        ratio,
    };
    // With damping alone it is a velocity servo, or a motor with passive damping.
    let is_motor = stiffness == 0.0 && damping != gain && is("dyntype", "none");
    Law { gain: is_motor.then_some(gain), servo }
}
