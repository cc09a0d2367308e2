//! The motion `squat`: down, hold, up and rest with both feet planted.

use nalgebra::Isometry3;

use super::gait::keep_within_limits;
use super::{Frame, Motion, MotionError, MotionKind, SAMPLES};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::robot::{Kinematics, Leg, Robot};
use crate::spec::{Edition, Kind, Param, Section, Ty};

/// The registry entry.
pub static KIND: MotionKind = Entry {
    kind: Kind { name: "squat", since: Edition::ONE, doc: include_str!("squat.md"), params: &PARAMS, needs: &[] },
    build: |section, robot, _| build(section, robot),
};

static PARAMS: [Param; 6] = [
    Param::required("rest", Ty::Quantity(Dimension::TIME))
        .range(0.0, 60.0)
        .doc("Time in the default pose at the start of the cycle, and again at its end."),
    Param::required("move", Ty::Quantity(Dimension::TIME))
        .range(0.05, 60.0)
        .doc("Duration of going down, and of going up."),
    Param::required("hold", Ty::Quantity(Dimension::TIME)).range(0.0, 60.0).doc("Time in the squatting pose."),
    Param::required("hip_pitch", Ty::Quantity(Dimension::ANGLE)).doc("Hip pitch when squatting, about +y."),
    Param::required("knee", Ty::Quantity(Dimension::ANGLE)).doc("Knee when squatting, about +y."),
    Param::required("ankle_pitch", Ty::Quantity(Dimension::ANGLE)).doc("Ankle pitch when squatting, about +y."),
];

fn build(section: Section, robot: &Robot) -> Result<Motion, MotionError> {
    let (rest, travel, hold) = (section.si("rest"), section.si("move"), section.si("hold"));
    let period = 2.0 * (rest + travel) + hold;
    let low = squatting(section, robot)?;
    let standing = robot.default_pose();
    let mut samples: Vec<Frame> = (0..SAMPLES)
        .map(|index| {
            let time = period * index as f64 / SAMPLES as f64;
            frame(&standing, &low, depth(time, [rest, travel, hold]))
        })
        .collect();
    place_base(robot, period, &mut samples);
    keep_within_limits(robot, &mut samples)?;
    Ok(Motion { name: String::new(), period, speed: 0.0, samples })
}

/// The squatting pose.
fn squatting(section: Section, robot: &Robot) -> Result<Vec<f64>, MotionError> {
    let mut pose = robot.default_pose();
    for side in 0..2 {
        let pitches = Leg::pitches(robot, side).ok_or(MotionError::Legs)?;
        for (key, (joint, sign)) in ["hip_pitch", "knee", "ankle_pitch"].into_iter().zip(pitches) {
            pose[joint] = sign * section.si(key);
        }
    }
    Ok(pose)
}

/// How far down, from 0 to 1, with first and second time derivative: a cubic in each direction.
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

/// Puts the base where the planted feet want it; its velocity and acceleration are central differences.
fn place_base(robot: &Robot, period: f64, samples: &mut [Frame]) {
    let mut kinematics = Kinematics::new(robot);
    let mut place = |frame: &Frame| {
        kinematics.place(&Isometry3::identity(), &frame.position);
        -(kinematics.sole(0).translation.vector + kinematics.sole(1).translation.vector) * 0.5
    };
    let places: Vec<_> = samples.iter().map(&mut place).collect();
    let (count, step) = (places.len(), period / places.len() as f64);
    for (index, frame) in samples.iter_mut().enumerate() {
        let (before, here, after) = (places[(index + count - 1) % count], places[index], places[(index + 1) % count]);
        frame.base_height = here.z;
        frame.base_velocity = ((after - before) / (2.0 * step)).into();
        frame.base_acceleration = ((after - here * 2.0 + before) / (step * step)).into();
    }
}
