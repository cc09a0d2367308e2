//! Converts a plan of base and foot into a gait: inverse kinematics of the left leg over one cycle, the right
//! leg as its mirror image half a cycle later, and smooth joint angles with exact derivatives.

use nalgebra::{Isometry3, UnitQuaternion};

use super::fourier::Series;
use super::{Frame, Motion, MotionError, SAMPLES};
use crate::robot::Kinematics;
use crate::robot::Robot;
use crate::robot::legs::{own, reach};

/// Largest error (m and rad together) between a planned foot pose and the one that the leg reaches.
pub(super) const RESIDUAL: f64 = 1e-9;

/// The planned state of a gait at one phase.
#[derive(Clone, Debug)]
pub(super) struct Stride {
    /// Height of the base origin above the ground in m.
    pub(super) height: f64,
    /// World from base.
    pub(super) orientation: UnitQuaternion<f64>,
    /// Velocity of the base origin in m/s, heading frame.
    pub(super) velocity: [f64; 3],
    /// Acceleration of the base origin in m/s^2, heading frame.
    pub(super) acceleration: [f64; 3],
    /// Pose of the left foot's link in the base frame.
    pub(super) left: Isometry3<f64>,
    /// Whether the left foot is in scheduled contact.
    pub(super) planted: bool,
}

/// Timing and smoothing of a gait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    /// Duration in s.
    pub(super) period: f64,
    /// Mean forward speed in m/s.
    pub(super) speed: f64,
    /// Number of harmonics of the joint angles.
    pub(super) harmonics: usize,
}

/// The gait of a robot whose plan is one [`Stride`] per sample.
pub(super) fn gait(robot: &Robot, cycle: Cycle, strides: &[Stride]) -> Result<Motion, MotionError> {
    let left = left_leg(robot, strides)?;
    let mut samples: Vec<Frame> = strides.iter().map(|stride| frame(robot, stride)).collect();
    let half = samples.len() / 2;
    for (index, stride) in strides.iter().enumerate() {
        samples[(index + half) % strides.len()].contact[1] = stride.planted;
    }
    for (joint, angles) in left {
        let (image, sign) = robot.mirror[joint];
        let series = Series::fit(&angles, cycle.harmonics);
        for index in 0..samples.len() {
            let [angle, rate, acceleration] = series.at(index as f64 / samples.len() as f64);
            let values = [angle, rate / cycle.period, acceleration / (cycle.period * cycle.period)];
            write(&mut samples[index], joint, values);
            let opposite = (index + half) % samples.len();
            write(&mut samples[opposite], image, values.map(|value| sign * value));
        }
    }
    keep_within_limits(robot, &mut samples)?;
    Ok(Motion { name: String::new(), period: cycle.period, speed: cycle.speed, samples })
}

/// Angles of the left leg's joints over the cycle: joint index and one angle per stride.
fn left_leg(robot: &Robot, strides: &[Stride]) -> Result<Vec<(usize, Vec<f64>)>, MotionError> {
    debug_assert_eq!(strides.len(), SAMPLES);
    let mut kinematics = Kinematics::new(robot);
    let mut angles: Vec<(usize, Vec<f64>)> =
        own(&kinematics, 0).into_iter().map(|joint| (joint, Vec::new())).collect();
    let mut position = robot.default_pose();
    for (index, stride) in strides.iter().enumerate() {
        let residual = reach(&mut kinematics, 0, &stride.left, &mut position);
        if residual.is_nan() || residual >= RESIDUAL {
            return Err(MotionError::OutOfReach { phase: index as f64 / strides.len() as f64, residual });
        }
        for (joint, angles) in &mut angles {
            angles.push(position[*joint]);
        }
    }
    Ok(angles)
}

fn frame(robot: &Robot, stride: &Stride) -> Frame {
    let turn = stride.orientation;
    Frame {
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        acceleration: vec![0.0; robot.joints()],
        base_height: stride.height,
        base_orientation: [turn.w, turn.i, turn.j, turn.k],
        base_velocity: stride.velocity,
        base_rate: [0.0; 3],
        base_acceleration: stride.acceleration,
        contact: [stride.planted, false],
    }
}

fn write(frame: &mut Frame, joint: usize, [angle, rate, acceleration]: [f64; 3]) {
    frame.position[joint] = angle;
    frame.velocity[joint] = rate;
    frame.acceleration[joint] = acceleration;
}

/// Excess (rad) over a limit up to which a joint angle is clipped.
const LIMIT_TOLERANCE: f64 = 0.02;

/// Clips joint angles that slightly exceed a limit, as smoothing may cause, and refuses larger excesses.
pub(super) fn keep_within_limits(robot: &Robot, samples: &mut [Frame]) -> Result<(), MotionError> {
    let count = samples.len() as f64;
    for (index, frame) in samples.iter_mut().enumerate() {
        for (link, position) in robot.links.iter().zip(&mut frame.position) {
            let joint = &link.joint;
            let within = position.clamp(joint.lower, joint.upper);
            if (*position - within).abs() > LIMIT_TOLERANCE {
                let (joint, position, phase) = (joint.name.clone(), *position, index as f64 / count);
                return Err(MotionError::OutsideLimits { joint, position, phase });
            }
            *position = within;
        }
    }
    Ok(())
}

/// The quintic ease `u^3 (10 - 15 u + 6 u^2)` from 0 to 1, at rest at both ends.
pub(super) fn ease(share: f64) -> f64 {
    share * share * share * (10.0 + share * (6.0 * share - 15.0))
}

/// A swing foot's lift `sin^2(pi u)`, from 0 to 1 and back.
pub(super) fn lift(share: f64) -> f64 {
    let sine = libm::sin(std::f64::consts::PI * share);
    sine * sine
}
