//! What the critic sees beyond the actor: truths of the simulator that the robot cannot measure.

use super::observation::normalised;
use crate::kinds::Signals;

/// How many numbers these are: base velocity 3, base rate 3, height 1, contacts 2, loads 2, mismatch 1.
pub const COUNT: usize = 12;

/// Bound of the normalised numbers.
const CLIP: f64 = 8.0;
/// Base velocity in m/s, base rate in rad/s, height difference in m and share of a cycle that show as 1.
const SCALES: [f64; 4] = [0.5, 0.5, 0.05, 0.2];

/// The scale of a robot.
#[derive(Clone, Copy, Debug)]
pub struct Privileged {
    /// Height of the base in m that shows as 0.
    pub height: f64,
    /// Weight of the robot in N; a foot that carries it all shows as 1.
    pub weight: f64,
}

impl Privileged {
    /// Writes the numbers, seen in the mirror plane y = 0 where `reflected`. `mismatch` is the share of a
    /// cycle for which each foot has contradicted the schedule.
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
