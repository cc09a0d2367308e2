//! The motion `walk`: a flat-footed walk in closed form, scaled to the robot's legs and anchored at its
//! standing pose.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::gait::{Cycle, Stride, ease, gait, lift};
use super::{Formula, Motion, MotionError, SAMPLES};
use crate::robot::{Kinematics, Robot};
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the double support.
    pub WholeCycle = "a cycle";
}

kind! {
    pub struct Walk = "walk" {
        /// Duration of a cycle of two steps.
        #[range(0.1, 60.0)]
        period: Quantified<Second>,
        /// Leg length to which the lengths below refer; they are scaled to the robot's leg length.
        #[range(0.01, 10.0)]
        reference_leg_length: Quantified<Metre>,
        /// Length of a step.
        #[range(0.0, 5.0)]
        step_length: Quantified<Metre>,
        /// Height of the foot at mid-swing.
        #[range(0.0, 5.0)]
        foot_lift: Quantified<Metre>,
        /// Lateral distance of a foot from the centre line.
        #[range(0.0, 5.0)]
        half_foot_spacing: Quantified<Metre>,
        /// Additional distance of the ankle in front of the base at mid-stance, relative to the standing
        /// pose.
        #[range(-5.0, 5.0)]
        forward_offset: Quantified<Metre>,
        /// Lateral sway of the base, once per cycle.
        #[range(-5.0, 5.0)]
        sway: Quantified<Metre>,
        /// Third harmonic of the sway.
        #[range(-5.0, 5.0)]
        sway_third: Quantified<Metre>,
        /// Fore-aft oscillation of the base about its mean motion, twice per cycle.
        #[range(-5.0, 5.0)]
        speed_ripple: Quantified<Metre>,
        /// Phase lag of the base's oscillations behind the steps.
        #[range(-0.5, 0.5)]
        phase_shift: f64,
        /// Duration of each of the two double-support phases.
        #[range(0.0, 0.45)]
        double_support: Ratio<WholeCycle>,
        /// Harmonics of the Fourier series that smooths the joint angles.
        #[range(1.0, 100.0)]
        harmonics: usize,
    }
}

/// The closed form with the robot's lengths.
struct ScaledWalk {
    period: f64,
    step: f64,
    lift: f64,
    spacing: f64,
    sway: [f64; 2],
    ripple: f64,
    shift: f64,
    double: f64,
    /// Ankle in the base frame at mid-stance.
    anchor: [f64; 2],
    height: f64,
}

impl Formula for Walk {
    fn motion(&self, robot: &Robot, _: Option<&str>) -> Result<Motion, MotionError> {
        let walk = ScaledWalk::new(self, robot)?;
        let strides: Vec<Stride> =
            (0..SAMPLES).map(|index| walk.stride(index as f64 / SAMPLES as f64)).collect();
        let speed = 2.0 * walk.step / walk.period;
        gait(robot, Cycle { period: walk.period, speed, harmonics: self.harmonics }, &strides)
    }

    fn period(&self) -> f64 {
        self.period
    }
}

impl ScaledWalk {
    fn new(walk: &Walk, robot: &Robot) -> Result<Self, MotionError> {
        let scale = super::scale(walk.reference_leg_length, robot)?;
        let standing = Kinematics::new(robot);
        let ankle = standing.pose(robot.feet[0].link).translation.vector;
        Ok(Self {
            period: walk.period,
            step: scale * walk.step_length,
            lift: scale * walk.foot_lift,
            spacing: scale * walk.half_foot_spacing,
            sway: [scale * walk.sway, scale * walk.sway_third],
            ripple: scale * walk.speed_ripple,
            shift: walk.phase_shift,
            double: walk.double_support,
            anchor: [ankle.x + scale * walk.forward_offset, ankle.z],
            height: robot.standing_height,
        })
    }

    /// Share of the left foot's swing that has passed; `None` in stance.
    fn swing(&self, phase: f64) -> Option<f64> {
        let (start, end) = (0.5 * self.double, 0.5 - 0.5 * self.double);
        let share = (phase - start) / (end - start);
        // A small tolerance makes the schedules of both feet equal if they coincide with a sample.
        (-1e-9..1.0 - 1e-9).contains(&share).then(|| share.max(0.0))
    }

    /// The base's forward displacement relative to its mean motion and its lateral position, with first and
    /// second time derivatives.
    fn base(&self, phase: f64) -> [[f64; 3]; 2] {
        let wave = |amplitude: f64, harmonic: f64| {
            let pulse = TAU * harmonic / self.period;
            let (sine, cosine) = libm::sincos(TAU * harmonic * (phase - self.shift));
            [amplitude * sine, amplitude * pulse * cosine, -amplitude * pulse * pulse * sine]
        };
        let (first, third) = (wave(self.sway[0], 1.0), wave(self.sway[1], 3.0));
        [wave(self.ripple, 2.0), std::array::from_fn(|order| -first[order] - third[order])]
    }

    fn stride(&self, phase: f64) -> Stride {
        let swing = self.swing(phase);
        let (moved, lifted) = match swing {
            Some(share) => (ease(share), lift(share)),
            None => (if phase < 0.25 { 0.0 } else { 1.0 }, 0.0),
        };
        // Forward position of the left foot; at phase 0.75, at its mid-stance, the base has moved by one and
        // a half steps since phase 0, so that the ankle is at `anchor` relative to it.
        let foot = self.step * (2.0 * moved - 1.0);
        let [ripple, sway] = self.base(phase);
        let base = self.step * (2.0 * phase - 0.5) - self.anchor[0] + ripple[0];
        let left =
            Translation3::new(foot - base, self.spacing - sway[0], self.anchor[1] + self.lift * lifted);
        Stride {
            height: self.height,
            orientation: UnitQuaternion::identity(),
            velocity: [2.0 * self.step / self.period + ripple[1], sway[1], 0.0],
            acceleration: [ripple[2], sway[2], 0.0],
            left: Isometry3::from_parts(left, UnitQuaternion::identity()),
            planted: swing.is_none(),
        }
    }
}
