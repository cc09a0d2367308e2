//! The low-level law in a contract: how the network's outputs become torques.

use serde::{Deserialize, Serialize};

use crate::control::{Law, words};
use crate::kinds::action::Action;
use crate::robot::Robot;

/// An output of the network; its command is `clamp(offset + scale * output, limits)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Its index in the vector.
    pub index: usize,
    /// `torque`, `position` or `phase_advance`.
    pub command: String,
    /// The joint that it commands.
    pub joint: Option<String>,
    /// SI unit of the command.
    pub unit: String,
    /// Command for an output of 0.
    pub offset: f64,
    /// Change of the command per unit of the output.
    pub scale: f64,
    /// Bounds of the command.
    pub limits: [f64; 2],
}

/// The low-level law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LowLevel {
    /// `torque` or `position`.
    pub kind: String,
    /// The law in one line, for human readers.
    pub sentence: String,
    /// Proportional gains in N m/rad by joint; empty under torque control.
    pub stiffness: Vec<f64>,
    /// Derivative gains in N m s/rad by joint; empty under torque control.
    pub damping: Vec<f64>,
    /// Bounds of the torques in N m by joint.
    pub effort_limits: Vec<f64>,
    /// Time in s from a torque command to its effect.
    pub delay: f64,
    /// Rate of the position servo in Hz, under position control.
    pub servo_rate: Option<f64>,
    /// Joint speeds in rad/s at which torque that accelerates the joint begins to fade, to zero at 1.25 times
    /// that speed; empty if the motors have no such limit.
    pub speed_limits: Vec<f64>,
}

impl LowLevel {
    /// The law of `[action]` for this robot.
    pub fn new(action: &Action, robot: &Robot) -> Self {
        let law = Law::new(action, robot);
        let position = action.servo().is_some();
        let gains: Vec<(f64, f64)> = if position { law.gains().collect() } else { Vec::new() };
        let limited = action.motor_speed_limit();
        let speeds = robot.links.iter().filter(|_| limited).map(|link| link.joint.velocity_limit);
        Self {
            sentence: words::nominal_law(action),
            kind: action.kind().to_owned(),
            stiffness: gains.iter().map(|gain| gain.0).collect(),
            damping: gains.iter().map(|gain| gain.1).collect(),
            effort_limits: robot.effort_limits(),
            delay: action.delay(),
            servo_rate: law.servo_rate(),
            speed_limits: speeds.collect(),
        }
    }
}

/// The outputs of a policy under `[action]`.
pub fn outputs(action: &Action, robot: &Robot) -> Vec<Output> {
    let law = Law::new(action, robot);
    let position = action.servo().is_some();
    let joints = robot.links.iter().zip(law.units().zip(law.limits())).enumerate();
    let joints = joints.map(|(index, (link, (scale, limits)))| {
        let joint = &link.joint;
        Output {
            index,
            command: if position { "position" } else { "torque" }.into(),
            joint: Some(joint.name.clone()),
            unit: if position { "rad" } else { "N*m" }.into(),
            offset: if position { joint.default_position } else { 0.0 },
            scale,
            limits,
        }
    });
    let mut outputs: Vec<Output> = joints.collect();
    if action.phase_modulation() {
        outputs.push(Output {
            index: outputs.len(),
            command: "phase_advance".into(),
            joint: None,
            unit: "1".into(),
            offset: 0.0,
            scale: 1.0,
            limits: [0.0, 1.0],
        });
    }
    outputs
}
