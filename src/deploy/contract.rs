//! The contract of an exported policy: everything that a program needs to run it.
//!
//! All values are SI. A reader measures the inputs in order, normalises each as `clamp((raw - offset) /
//! scale, -clip, clip)`, runs the network, turns each output into a command `clamp(offset + scale * output,
//! limits)` and applies the low-level law at the stated rates.

use serde::{Deserialize, Serialize};

use super::law::{LowLevel, Output, outputs};
use crate::env::Observation;
use crate::env::blueprint::{cycle, phase_gain};
use crate::kinds::action::Action;
use crate::kinds::initial::Initial;
use crate::kinds::initial::default_pose::DefaultPose;
use crate::kinds::motion::Motion;
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_velocity::JointVelocity;
use crate::kinds::physics::Physics;
use crate::robot::Robot;
use crate::spec::typed::Declared;
use crate::spec::{Section, Table};

/// Version of the contract's layout; a reader refuses any other.
pub const VERSION: u32 = 1;

/// The contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contract {
    /// Version of this layout.
    pub version: u32,
    /// The robot that the policy was trained on.
    pub robot: RobotMark,
    /// Rates of measurement, policy and servo.
    pub rates: Rates,
    /// The network's inputs in order.
    pub inputs: Vec<InputEntry>,
    /// The network's outputs in order.
    pub outputs: Vec<Output>,
    /// The control law that converts commands into torques.
    pub law: LowLevel,
    /// Measurement of joint velocities.
    pub filter: Filter,
    /// Progress of the phase.
    pub phase: Phase,
    /// Mirroring of the second half of a cycle.
    pub symmetry: Symmetry,
    /// Origin of the policy.
    pub provenance: Provenance,
}

/// The robot of a contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMark {
    /// Its name.
    pub name: String,
    /// BLAKE3 of all parameters of its model.
    pub digest: String,
    /// Total mass in kg, for human readers.
    pub total_mass: f64,
    /// Names of the joints in joint order.
    pub joints: Vec<String>,
}

/// Rates in Hz.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rates {
    /// Encoders and velocity filter; the physics rate of the training.
    pub measurement: f64,
    /// The policy.
    pub control: f64,
    /// The position servo, under position control.
    pub servo: Option<f64>,
}

/// An input of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputEntry {
    /// Its index in the vector.
    pub index: usize,
    /// The signal (`base_roll`, `joint_position`).
    pub signal: String,
    /// The joint it belongs to.
    pub joint: Option<String>,
    /// SI unit of the raw value.
    pub unit: String,
    /// Rate at which the policy reads it, in Hz.
    pub rate: f64,
    /// Raw value that is normalised to 0.
    pub offset: f64,
    /// Raw difference that is normalised to 1.
    pub scale: f64,
    /// Bound on the normalised value.
    pub clip: f64,
}

/// How joint velocities come from encoder positions: the difference of successive positions over the
/// measurement interval, then `y += share * (x - y)` with `share = dt / (1 / (2 pi f) + dt)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filter {
    /// Cut-off frequency f in Hz; `None` is without a filter.
    pub low_pass: Option<f64>,
    /// The share at the measurement rate.
    pub share: f64,
}

/// Progress of the phase: `(1 + gain a) / (period * control rate)` per control step, modulo 1, where `a` is
/// the phase output within its limits, or 0 without one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Duration of a cycle in s at the nominal cadence: of the reference motion, or the default cycle of
    /// tasks without one.
    pub period: f64,
    /// Whether the last output speeds the phase up.
    pub modulation: bool,
    /// Relative increase of the cadence at an output of 1; 1 if missing.
    #[serde(default = "Phase::whole", skip_serializing_if = "Phase::is_whole")]
    pub gain: f64,
    /// Phases at which an episode may start.
    pub starts: Vec<f64>,
}

impl Phase {
    fn whole() -> f64 {
        1.0
    }

    fn is_whole(gain: &f64) -> bool {
        *gain == 1.0
    }
}

/// The mirroring rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Symmetry {
    /// `none`, or `phase_mirror`: at phase 1/2 and beyond, the policy gets mirrored roll, yaw and joints and
    /// phase - 1/2, and its joint outputs are mirrored back.
    pub rule: String,
    /// For each joint its mirror image and the sign of the mirrored coordinate.
    pub mirror: Vec<Image>,
}

/// The mirror image of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// The joint.
    pub joint: String,
    /// Its image.
    pub image: String,
    /// 1 or -1.
    pub sign: f64,
}

/// Origin of a policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of specforge.
    pub version: String,
    /// Its commit.
    pub commit: String,
    /// Fingerprint of the learner's stage.
    pub learner: Option<String>,
}

impl Provenance {
    /// This build, and the stage that trained the weights.
    pub fn of_build(learner: Option<String>) -> Self {
        let (version, commit) = (env!("CARGO_PKG_VERSION").into(), env!("SPECFORGE_COMMIT").into());
        Self { version, commit, learner }
    }
}

/// BLAKE3 of all parameters of a robot model, as hex.
pub fn robot_digest(robot: &Robot) -> String {
    let text = serde_json::to_string(robot).expect("a robot is plain data");
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

impl Contract {
    /// The contract of a policy for the environment of these decoded fields.
    pub fn new(fields: &Table, robot: &Robot, motion: Option<&Motion>, provenance: Provenance) -> Self {
        let section = Section::new(fields);
        let observation = Observation::new(fields, robot);
        let action: Action = section.part().expect("a blueprint has an action");
        let measurement = section.at(Physics::rate).expect("a blueprint has physics");
        let control = action.rate();
        let law = LowLevel::new(&action, robot);
        Self {
            version: VERSION,
            robot: RobotMark::of(robot),
            rates: Rates { measurement, control, servo: law.servo_rate },
            inputs: inputs(&observation, control),
            outputs: outputs(&action, robot),
            law,
            filter: Filter::new(section, measurement),
            phase: Phase {
                period: cycle(motion),
                modulation: action.phase_modulation(),
                gain: phase_gain(&action, motion),
                starts: starts(section),
            },
            symmetry: Symmetry::new(observation.is_mirrored(), robot),
            provenance,
        }
    }

    /// The first difference between the demands of two contracts, for a message; `None` if they agree in
    /// everything except provenance and the robot's parameters.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let parts = [
            ("version", same(&self.version, &other.version)),
            ("robot's joints", same(&self.robot.joints, &other.robot.joints)),
            ("rates", same(&self.rates, &other.rates)),
            ("number of inputs", same(&self.inputs.len(), &other.inputs.len())),
            ("number of outputs", same(&self.outputs.len(), &other.outputs.len())),
            ("law", same(&self.law, &other.law)),
            ("filter", same(&self.filter, &other.filter)),
            ("phase", same(&self.phase, &other.phase)),
            ("symmetry", same(&self.symmetry, &other.symmetry)),
        ];
        let part =
            parts.into_iter().find_map(|(name, difference)| difference.map(|text| format!("{name}: {text}")));
        let input = || entry("input", &self.inputs, &other.inputs);
        let output = || entry("output", &self.outputs, &other.outputs);
        part.or_else(input).or_else(output)
    }
}

impl RobotMark {
    /// The identification of a robot.
    pub fn of(robot: &Robot) -> Self {
        Self {
            name: robot.name.clone(),
            digest: robot_digest(robot),
            total_mass: robot.total_mass(),
            joints: robot.links.iter().map(|link| link.joint.name.clone()).collect(),
        }
    }
}

impl Filter {
    fn new(fields: Section, rate: f64) -> Self {
        let terms = fields.within::<Observations>().into_iter().flat_map(|section| section.sections());
        let mut velocities =
            terms.filter(|(name, term)| term.kind().unwrap_or(name) == JointVelocity::KIND.name);
        let low_pass = velocities.find_map(|(_, term)| term.value(JointVelocity::low_pass));
        let share = low_pass.map_or(1.0, |cutoff| crate::control::LowPass::new(cutoff, 1.0 / rate).share());
        Self { low_pass, share }
    }
}

impl Symmetry {
    fn new(mirrored: bool, robot: &Robot) -> Self {
        let name = |joint: usize| robot.links[joint].joint.name.clone();
        let images = robot.mirror.iter().enumerate();
        let mirror = images.map(|(joint, (image, sign))| Image {
            joint: name(joint),
            image: name(*image),
            sign: *sign,
        });
        let rule = if mirrored { "phase_mirror" } else { "none" };
        Self { rule: rule.into(), mirror: mirror.collect() }
    }
}

fn inputs(observation: &Observation, rate: f64) -> Vec<InputEntry> {
    let entries = observation.inputs().iter().enumerate().map(|(index, input)| InputEntry {
        index,
        signal: input.name.clone(),
        joint: input.joint.clone(),
        unit: input.unit.clone(),
        rate,
        offset: input.offset,
        scale: input.scale,
        clip: input.clip,
    });
    entries.collect()
}

fn starts(fields: Section) -> Vec<f64> {
    let initial = fields.within::<Initial>();
    initial.and_then(|initial| initial.value(DefaultPose::phases)).unwrap_or_else(|| vec![0.0])
}

/// `None` if equal, otherwise both values.
fn same<T: PartialEq + Serialize>(one: &T, other: &T) -> Option<String> {
    let text = |value: &T| serde_json::to_string(value).unwrap_or_default();
    (one != other).then(|| format!("{} against {}", text(one), text(other)))
}

/// The first difference between two lists.
fn entry<T: PartialEq + Serialize>(name: &str, one: &[T], other: &[T]) -> Option<String> {
    let mut pairs = one.iter().zip(other).enumerate();
    pairs.find_map(|(index, (one, other))| same(one, other).map(|text| format!("{name} {index}: {text}")))
}
