//! The motion `squat`: down, hold, up and rest, with both feet planted.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::gait::{RESIDUAL, keep_within_limits};
use super::{Formula, Frame, Motion, MotionError, SAMPLES};
use crate::robot::legs::reach;
use crate::robot::{Kinematics, Leg, Robot};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Squat = "squat" {
        /// Time in the default pose at the start of the cycle, and again at its end.
        #[range(0.0, 60.0)]
        rest: Quantified<Second>,
        /// Duration of the way down, and of the way up.
        #[range(0.05, 60.0)]
        r#move: Quantified<Second>,
        /// Time in the squatting pose.
        #[range(0.0, 60.0)]
        hold: Quantified<Second>,
        /// Hip pitch in the squatting pose, about +y.
        #[range(-3.2, 3.2)]
        hip_pitch: Quantified<Radian>,
        /// Knee angle in the squatting pose, about +y.
        #[range(-3.2, 3.2)]
        knee: Quantified<Radian>,
        /// Ankle pitch in the squatting pose, about +y.
        #[range(-3.2, 3.2)]
        ankle_pitch: Quantified<Radian>,
    }
}

impl Formula for Squat {
    fn motion(&self, robot: &Robot, _: Option<&str>) -> Result<Motion, MotionError> {
        squats(self, robot)
    }

    fn period(&self) -> f64 {
        period(self)
    }
}

/// Duration of a cycle in s: rest, down, hold, up, rest.
fn period(squat: &Squat) -> f64 {
    2.0 * (squat.rest + squat.r#move) + squat.hold
}

/// The motion of a robot.
fn squats(squat: &Squat, robot: &Robot) -> Result<Motion, MotionError> {
    let (rest, travel, hold) = (squat.rest, squat.r#move, squat.hold);
    let period = period(squat);
    let low = squatting(squat, robot)?;
    let standing = robot.default_pose();
    let times = (0..SAMPLES).map(|index| period * index as f64 / SAMPLES as f64);
    let depths: Vec<[f64; 3]> = times.map(|time| depth(time, [rest, travel, hold])).collect();
    let mut samples: Vec<Frame> = depths.iter().map(|depth| frame(&standing, &low, *depth)).collect();
    if is_aslant(robot)? && !stays_planted(robot, &standing, &low) {
        plant(robot, period, &low, &depths, &mut samples)?;
    }
    place_base(robot, period, &mut samples);
    keep_within_limits(robot, &mut samples)?;
    Ok(Motion { name: String::new(), period, speed: 0.0, samples })
}

/// The squatting pose.
fn squatting(squat: &Squat, robot: &Robot) -> Result<Vec<f64>, MotionError> {
    let mut pose = robot.default_pose();
    for side in 0..2 {
        let pitches = Leg::pitches(robot, side).ok_or_else(|| MotionError::legs(robot))?;
        for (angle, (joint, sign)) in
            [squat.hip_pitch, squat.knee, squat.ankle_pitch].into_iter().zip(pitches)
        {
            pose[joint] = sign * angle;
        }
    }
    Ok(pose)
}

/// Largest tilt of a sole in rad on the way down, and largest displacement in m of one sole relative to the
/// other, for planted feet.
const PLANTED: [f64; 2] = [0.01, 5e-3];

/// Angle in rad to the base's y axis from which a pitch joint is oblique.
const ASLANT: f64 = 0.01;

/// Whether a pitch joint of a leg has another axis than the base's y; the file's angles then do not keep the
/// foot flat.
fn is_aslant(robot: &Robot) -> Result<bool, MotionError> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    for side in 0..2 {
        let pitches = Leg::pitches(robot, side).ok_or_else(|| MotionError::legs(robot))?;
        let off = |joint: usize| {
            let axis = kinematics.axis(joint);
            libm::hypot(axis.x, axis.z)
        };
        if pitches.iter().any(|(joint, _)| off(*joint) > ASLANT) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether both soles stay in place while the joints move from one pose to the other.
fn stays_planted(robot: &Robot, standing: &[f64], low: &[f64]) -> bool {
    let mut kinematics = Kinematics::new(robot);
    let mut soles = |share: f64| {
        let position: Vec<f64> =
            standing.iter().zip(low).map(|(high, low)| high + share * (low - high)).collect();
        kinematics.place(&Isometry3::identity(), &position);
        [0, 1].map(|side| kinematics.sole(side))
    };
    let apart = |[left, right]: &[Isometry3<f64>; 2]| left.translation.vector - right.translation.vector;
    let start = soles(0.0);
    [0.25, 0.5, 0.75, 1.0].into_iter().all(|share| {
        let now = soles(share);
        let tilts = [0, 1]
            .map(|side| (now[side].rotation * Vector3::z() - start[side].rotation * Vector3::z()).norm());
        let slid = (apart(&now) - apart(&start)).norm();
        tilts.iter().all(|tilt| *tilt < PLANTED[0]) && slid < PLANTED[1]
    })
}

/// Moves down with both feet planted by inverse kinematics: the base moves down and sideways as it does in
/// the squatting pose, with the feet where they stand. Velocities and accelerations are central differences.
fn plant(
    robot: &Robot,
    period: f64,
    low: &[f64],
    depths: &[[f64; 3]],
    samples: &mut [Frame],
) -> Result<(), MotionError> {
    let mut kinematics = Kinematics::new(robot);
    let feet = [0, 1].map(|side| *kinematics.pose(robot.feet[side].link));
    let middle = |kinematics: &Kinematics| {
        0.5 * (kinematics.sole(0).translation.vector + kinematics.sole(1).translation.vector)
    };
    let stands = middle(&kinematics);
    kinematics.place(&Isometry3::identity(), low);
    let way = middle(&kinematics) - stands;
    let way = Vector3::new(way.x, 0.0, way.z);
    for (index, ([share, ..], frame)) in depths.iter().zip(samples.iter_mut()).enumerate() {
        // Straight knees can bend either way: the intermediate pose determines the direction.
        let mut position = frame.position.clone();
        for (side, foot) in feet.iter().enumerate() {
            let target = Translation3::from(way * *share) * *foot;
            let residual = reach(&mut kinematics, side, &target, &mut position);
            if residual.is_nan() || residual >= RESIDUAL {
                return Err(MotionError::OutOfReach { phase: index as f64 / depths.len() as f64, residual });
            }
        }
        frame.position = position;
    }
    let places: Vec<Vec<f64>> = samples.iter().map(|frame| frame.position.clone()).collect();
    let (count, step) = (places.len(), period / places.len() as f64);
    for (index, frame) in samples.iter_mut().enumerate() {
        let (before, here, after) =
            (&places[(index + count - 1) % count], &places[index], &places[(index + 1) % count]);
        for joint in 0..here.len() {
            frame.velocity[joint] = (after[joint] - before[joint]) / (2.0 * step);
            frame.acceleration[joint] = (after[joint] - 2.0 * here[joint] + before[joint]) / (step * step);
        }
    }
    Ok(())
}

/// Depth from 0 to 1, with first and second time derivative: a cubic in each direction.
fn depth(time: f64, [rest, travel, hold]: [f64; 3]) -> [f64; 3] {
    let cubic = |share: f64| {
        [
            share * share * (3.0 - 2.0 * share),
            6.0 * share * (1.0 - share) / travel,
            (6.0 - 12.0 * share) / (travel * travel),
        ]
    };
    let (down, up) = ((time - rest) / travel, (time - rest - travel - hold) / travel);
    if (0.0..1.0).contains(&down) {
        cubic(down)
    } else if (0.0..1.0).contains(&up) {
        let [share, rate, acceleration] = cubic(up);
        [1.0 - share, -rate, -acceleration]
    } else if down >= 1.0 && up < 0.0 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 0.0, 0.0]
    }
}

fn frame(standing: &[f64], low: &[f64], [share, rate, acceleration]: [f64; 3]) -> Frame {
    let blend = |factor: f64| standing.iter().zip(low).map(move |(high, low)| factor * (low - high));
    Frame {
        position: blend(share).zip(standing).map(|(change, standing)| standing + change).collect(),
        velocity: blend(rate).collect(),
        acceleration: blend(acceleration).collect(),
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [true, true],
        ..Frame::default()
    }
}

/// Moves the base such that the feet stay planted; its velocity and acceleration are central differences.
fn place_base(robot: &Robot, period: f64, samples: &mut [Frame]) {
    let mut kinematics = Kinematics::new(robot);
    let mut place = |frame: &Frame| {
        kinematics.place(&Isometry3::identity(), &frame.position);
        -(kinematics.sole(0).translation.vector + kinematics.sole(1).translation.vector) * 0.5
    };
    let places: Vec<_> = samples.iter().map(&mut place).collect();
    let (count, step) = (places.len(), period / places.len() as f64);
    for (index, frame) in samples.iter_mut().enumerate() {
        let (before, here, after) =
            (places[(index + count - 1) % count], places[index], places[(index + 1) % count]);
        frame.base_height = here.z;
        frame.base_velocity = ((after - before) / (2.0 * step)).into();
        frame.base_acceleration = ((after - here * 2.0 + before) / (step * step)).into();
    }
}
