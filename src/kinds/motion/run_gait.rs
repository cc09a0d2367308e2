//! The motion `run_gait`: a closed-form run with ballistic flight phases.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::gait::{Cycle, Stride, ease, gait, lift};
use super::{Formula, Motion, MotionError, SAMPLES};
use crate::robot::kinematics::rotation_about;
use crate::robot::{GRAVITY, Kinematics, Leg, Robot, leg_length};
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the flight share.
    pub Step = "a step";
    /// Reference of a leg's extension.
    pub LegLength = "the leg length";
}

kind! {
    pub struct RunGait = "run_gait" {
        /// Duration of a cycle of two steps.
        #[range(0.1, 60.0)]
        period: Quantified<Second>,
        /// Share of a step without ground contact.
        #[range(0.0, 0.9)]
        flight: Ratio<Step>,
        /// Forward speed; does not scale with leg length.
        #[range(-10.0, 10.0)]
        speed: Quantified<MetrePerSecond>,
        /// Forward lean of the trunk.
        #[range(-0.7, 0.7)]
        lean: Quantified<Radian>,
        /// Leg length to which the lengths below refer; they are scaled to the robot's leg length.
        #[range(0.01, 10.0)]
        reference_leg_length: Quantified<Metre>,
        /// Height of the foot at mid-swing.
        #[range(0.0, 5.0)]
        foot_lift: Quantified<Metre>,
        /// Lateral distance of a foot from the centre line.
        #[range(0.0, 5.0)]
        half_foot_spacing: Quantified<Metre>,
        /// Lateral sway of the base towards the stance foot.
        #[range(-5.0, 5.0)]
        sway: Quantified<Metre>,
        /// Distance of the ankle at mid-stance behind the centre of mass of the leaning standing pose.
        #[range(-5.0, 5.0)]
        setback: Quantified<Metre>,
        /// Largest distance between hip and ankle in stance; keeps the knee bent.
        #[range(0.3, 0.999)]
        reach: Ratio<LegLength>,
        /// Harmonics of the Fourier series that smooths the joint angles.
        #[range(1.0, 100.0)]
        harmonics: usize,
    }
}

/// The closed form with the robot's lengths.
struct ScaledRun {
    period: f64,
    speed: f64,
    stance: f64,
    lift: f64,
    spacing: f64,
    sway: f64,
    lean: UnitQuaternion<f64>,
    /// Distance of the ankle at mid-stance in front of the base origin.
    ahead: f64,
    /// Height of the ankle above its sole.
    ankle: f64,
    bounce: Bounce,
    /// Height of the base at touch-down.
    height: f64,
}

impl Formula for RunGait {
    fn motion(&self, robot: &Robot, _: Option<&str>) -> Result<Motion, MotionError> {
        let mut run = ScaledRun::new(self, robot)?;
        run.height = run.lowest_height(self.reach, robot)?;
        let strides: Vec<Stride> =
            (0..SAMPLES).map(|index| run.stride(index as f64 / SAMPLES as f64)).collect();
        gait(robot, Cycle { period: run.period, speed: run.speed, harmonics: self.harmonics }, &strides)
    }

    fn period(&self) -> f64 {
        self.period
    }
}

impl ScaledRun {
    fn new(gait: &RunGait, robot: &Robot) -> Result<Self, MotionError> {
        let scale = super::scale(gait.reference_leg_length, robot)?;
        let lean = rotation_about(&Vector3::y(), gait.lean);
        let mut standing = Kinematics::new(robot);
        standing.place(&Isometry3::from_parts(Translation3::identity(), lean), &robot.default_pose());
        let step = 0.5 * gait.period;
        let stance = step * (1.0 - gait.flight);
        Ok(Self {
            period: gait.period,
            speed: gait.speed,
            stance,
            lift: scale * gait.foot_lift,
            spacing: scale * gait.half_foot_spacing,
            sway: scale * gait.sway,
            lean,
            ahead: standing.com().x - scale * gait.setback,
            ankle: -robot.feet[0].sole(),
            bounce: Bounce::new(step, stance),
            height: 0.0,
        })
    }

    /// The left ankle relative to the base origin at height zero, world axes, `time` after its touch-down.
    fn ankle(&self, time: f64) -> Vector3<f64> {
        let swing = self.period - self.stance;
        let (ahead, lifted) = if time < self.stance {
            (-self.speed * (time - 0.5 * self.stance), 0.0)
        } else {
            let share = (time - self.stance) / swing;
            let travelled = self.speed * (self.period * ease(share) - share * swing);
            (travelled - 0.5 * self.speed * self.stance, lift(share))
        };
        Vector3::new(
            self.ahead + ahead,
            self.spacing - self.sideways(time)[0],
            self.ankle + self.lift * lifted,
        )
    }

    /// The base's lateral position, velocity and acceleration: towards the left foot at mid-stance of the
    /// left foot.
    fn sideways(&self, time: f64) -> [f64; 3] {
        let pulse = TAU / self.period;
        let (sine, cosine) = libm::sincos(pulse * (time - 0.5 * self.stance));
        [self.sway * cosine, -self.sway * pulse * sine, -self.sway * pulse * pulse * cosine]
    }

    /// The height of the base at touch-down at which the leg's largest extension in stance is `reach` of its
    /// length.
    fn lowest_height(&self, reach: f64, robot: &Robot) -> Result<f64, MotionError> {
        let length = reach * leg_length(robot).ok_or_else(|| MotionError::legs(robot))?;
        let [(hip, _), ..] = Leg::pitches(robot, 0).ok_or_else(|| MotionError::legs(robot))?;
        let hip = self.lean * Kinematics::new(robot).pose(hip).translation.vector;
        let heights = (0..=SAMPLES).map(|index| {
            let time = self.stance * index as f64 / SAMPLES as f64;
            let ankle = self.ankle(time.min(self.stance * (1.0 - 1e-12)));
            let across = libm::hypot(hip.x - ankle.x, hip.y - ankle.y);
            let above = libm::sqrt((length * length - across * across).max(0.0));
            ankle.z + above - hip.z - self.bounce.at(time)[0]
        });
        Ok(heights.fold(f64::INFINITY, f64::min))
    }

    fn stride(&self, phase: f64) -> Stride {
        let time = phase * self.period;
        let [rise, climb, thrust] = self.bounce.at(time % (0.5 * self.period));
        let height = self.height + rise;
        let sideways = self.sideways(time);
        let ankle = self.ankle(time) - Vector3::z() * height;
        let flat = Isometry3::from_parts(Translation3::from(ankle), UnitQuaternion::identity());
        Stride {
            height,
            orientation: self.lean,
            velocity: [self.speed, sideways[1], climb],
            acceleration: [0.0, sideways[2], thrust],
            left: Isometry3::from_parts(Translation3::identity(), self.lean.inverse()) * flat,
            planted: time < self.stance * (1.0 - 1e-9),
        }
    }
}

/// The vertical motion of one step: accelerated by a force `F0 sin(pi t / stance)^0.7` whose mean over the
/// step is the weight, then ballistic.
struct Bounce {
    stance: f64,
    /// Velocity at take-off, opposite to that at touch-down.
    take_off: f64,
    /// Height relative to touch-down, velocity and acceleration at equal intervals of the stance.
    table: Vec<[f64; 3]>,
}

impl Bounce {
    /// Number of intervals of the table.
    const INTERVALS: usize = 4096;

    fn new(step: f64, stance: f64) -> Self {
        let shape = |share: f64| libm::pow(libm::sin(PI * share).max(0.0), 0.7);
        let interval = stance / Self::INTERVALS as f64;
        let middle = |index: usize| shape((index as f64 + 0.5) / Self::INTERVALS as f64);
        let area: f64 = (0..Self::INTERVALS).map(middle).sum::<f64>() * interval;
        let peak = GRAVITY * step / area;
        let take_off = 0.5 * GRAVITY * (step - stance);
        let (mut height, mut velocity) = (0.0, -take_off);
        let mut table = Vec::with_capacity(Self::INTERVALS + 1);
        for index in 0..=Self::INTERVALS {
            table.push([height, velocity, peak * shape(index as f64 / Self::INTERVALS as f64) - GRAVITY]);
            let push = peak * middle(index.min(Self::INTERVALS - 1)) - GRAVITY;
            height += interval * (velocity + 0.5 * interval * push);
            velocity += interval * push;
        }
        Self { stance, take_off, table }
    }

    /// Height relative to touch-down in m, velocity in m/s and acceleration in m/s^2.
    fn at(&self, time: f64) -> [f64; 3] {
        if time >= self.stance {
            let flown = time - self.stance;
            return [
                flown * (self.take_off - 0.5 * GRAVITY * flown),
                self.take_off - GRAVITY * flown,
                -GRAVITY,
            ];
        }
        let place = time / self.stance * Self::INTERVALS as f64;
        let index = (place as usize).min(Self::INTERVALS - 1);
        let share = place - index as f64;
        std::array::from_fn(|order| {
            let (low, high) = (self.table[index][order], self.table[index + 1][order]);
            low + share * (high - low)
        })
    }
}
