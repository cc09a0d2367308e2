//! Reference motions: `specs/motions/NAME.toml` together with a robot gives a [`Motion`].

use serde::{Deserialize, Serialize};

/// A periodic reference motion of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Its name.
    pub name: String,
    /// Duration of a cycle in s.
    pub period: f64,
    /// Mean forward speed in m/s.
    pub speed: f64,
    /// Samples at phases `i / samples.len()`.
    pub samples: Vec<Frame>,
}

/// A reference motion at one phase. Joint vectors are in joint order, feet are left, right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Joint positions in rad.
    pub position: Vec<f64>,
    /// Joint velocities in rad/s at the nominal cadence.
    pub velocity: Vec<f64>,
    /// Joint accelerations in rad/s^2 at the nominal cadence.
    pub acceleration: Vec<f64>,
    /// Height of the base origin above flat ground in m.
    pub base_height: f64,
    /// Orientation of the base, unit quaternion w x y z.
    pub base_orientation: [f64; 4],
    /// Velocity of the base origin in m/s, heading frame.
    pub base_velocity: [f64; 3],
    /// Angular velocity of the base in rad/s, heading frame.
    pub base_rate: [f64; 3],
    /// Acceleration of the base origin in m/s^2, heading frame.
    pub base_acceleration: [f64; 3],
    /// Scheduled contact of each foot.
    pub contact: [bool; 2],
}

impl Motion {
    /// Writes the reference at a phase into `frame`, interpolated linearly between samples; the contact
    /// schedule is that of the sample at or before the phase. Allocates only when `frame` is empty.
    pub fn at(&self, phase: f64, frame: &mut Frame) {
        let count = self.samples.len();
        let place = (phase - libm::floor(phase)) * count as f64;
        let index = (place as usize).min(count - 1);
        let share = place - index as f64;
        let (low, high) = (&self.samples[index], &self.samples[(index + 1) % count]);
        let mix = |a: f64, b: f64| a + share * (b - a);
        let mix_all = |a: &[f64], b: &[f64], out: &mut Vec<f64>| {
            out.clear();
            out.extend(a.iter().zip(b).map(|(a, b)| mix(*a, *b)));
        };
        mix_all(&low.position, &high.position, &mut frame.position);
        mix_all(&low.velocity, &high.velocity, &mut frame.velocity);
        mix_all(&low.acceleration, &high.acceleration, &mut frame.acceleration);
        let mix3 = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| mix(a[i], b[i]));
        frame.base_height = mix(low.base_height, high.base_height);
        frame.base_velocity = mix3(low.base_velocity, high.base_velocity);
        frame.base_rate = mix3(low.base_rate, high.base_rate);
        frame.base_acceleration = mix3(low.base_acceleration, high.base_acceleration);
        let mut orientation: [f64; 4] = std::array::from_fn(|i| mix(low.base_orientation[i], high.base_orientation[i]));
        let norm = libm::sqrt(orientation.iter().map(|x| x * x).sum());
        orientation.iter_mut().for_each(|x| *x /= norm);
        frame.base_orientation = orientation;
        frame.contact = low.contact;
    }
}
