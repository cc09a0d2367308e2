//! The critic's privileged inputs: ground truth of the simulator that the robot cannot measure.

use super::observation::normalised;
use crate::kinds::Signals;

/// The number of values: base velocity 3, base rate 3, height 1, contacts 2, loads 2, mismatch 1.
pub const COUNT: usize = 12;

/// Bound on the normalised values.
const CLIP: f64 = 8.0;
/// Values that are normalised to 1: base velocity in m/s, base rate in rad/s, height difference in m and
/// share of a cycle.
const SCALES: [f64; 4] = [0.5, 0.5, 0.05, 0.2];

/// Reference values of a robot.
#[derive(Clone, Copy, Debug)]
pub struct Privileged {
    /// Height of the base in m that is normalised to 0.
    pub height: f64,
    /// Weight of the robot in N; a foot that carries all of it has the value 1.
    pub weight: f64,
}

impl Privileged {
    /// Writes the values, mirrored at the plane y = 0 if `reflected`. `mismatch` is the share of a cycle for
    /// which each foot has contradicted the schedule.
    pub fn write(&self, signals: &Signals, mismatch: f64, reflected: bool, vector: &mut [f32]) {
        let sign = if reflected { -1.0 } else { 1.0 };
        let (left, right) = if reflected { (1, 0) } else { (0, 1) };
        let [speed, rate, height, cycle] = SCALES;
        let [forward, side, up] = signals.base_velocity;
        let [roll, pitch, yaw] = signals.base_rate;
        let flag = |foot: usize| f64::from(u8::from(signals.foot_contact[foot]));
        let load = |foot: usize| signals.foot_force[foot][2] / self.weight;
        let numbers: [f64; COUNT] = [
            forward / speed,
            sign * side / speed,
            up / speed,
            sign * roll / rate,
            pitch / rate,
            sign * yaw / rate,
            (signals.base_height - self.height) / height,
            flag(left),
            flag(right),
            load(left),
            load(right),
            mismatch / cycle,
        ];
        for (number, raw) in vector.iter_mut().zip(numbers) {
            *number = normalised(raw, 0.0, 1.0, CLIP);
        }
    }
}
