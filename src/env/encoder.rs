//! The joint encoders: noisy positions, and velocities from their differences.

use crate::control::LowPass;
use crate::spec::Sampler;
use crate::stream::Stream;

/// Encoders of all joints, sampled once per physics step.
#[derive(Clone, Debug)]
pub struct Encoder {
    noise: Option<Sampler>,
    filter: LowPass,
    step: f64,
    offset: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    difference: Vec<f64>,
    draws: Vec<f64>,
    stream: Stream,
}

impl Encoder {
    /// Encoders with this noise in rad and velocity filter, read every `step` seconds.
    pub fn new(joints: usize, noise: Option<Sampler>, filter: LowPass, step: f64) -> Self {
        let still = vec![0.0; joints];
        Self {
            noise,
            filter,
            step,
            offset: still.clone(),
            position: still.clone(),
            velocity: still.clone(),
            difference: still.clone(),
            draws: still,
            stream: Stream::new(""),
        }
    }

    /// Starts an episode: joint positions in rad and velocities in rad/s, the initial filtered velocities in
    /// rad/s, and the constant offset of each joint's readings in rad.
    pub fn begin(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        shown: &[f64],
        offset: &[f64],
        stream: Stream,
    ) {
        self.stream = stream;
        self.offset.copy_from_slice(offset);
        self.velocity.copy_from_slice(shown);
        self.difference.copy_from_slice(velocity);
        self.draw();
        for (joint, position) in position.iter().enumerate() {
            self.position[joint] = position + self.offset[joint] + self.draws[joint];
        }
    }

    /// Reads the joints after a physics step.
    pub fn sample(&mut self, position: &[f64]) {
        self.draw();
        for (joint, position) in position.iter().enumerate() {
            let reading = position + self.offset[joint] + self.draws[joint];
            let rate = (reading - self.position[joint]) / self.step;
            self.velocity[joint] = self.filter.next(self.velocity[joint], rate);
            self.difference[joint] = rate;
            self.position[joint] = reading;
        }
    }

    /// Measured positions in rad.
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// Measured, filtered velocities in rad/s.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Differences of the last two measured positions, one physics step apart, in rad/s; before the second
    /// reading the velocities of the start.
    pub fn difference(&self) -> &[f64] {
        &self.difference
    }

    /// Offset of each reading in rad.
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// Draws the noise of one reading of all joints. This runs for every joint in every physics step, so a
    /// normal distribution uses the stream's fast generator.
    fn draw(&mut self) {
        match &self.noise {
            None => {}
            Some(Sampler::Normal([mean, deviation])) => {
                self.draws.iter_mut().for_each(|draw| *draw = mean + deviation * self.stream.normal());
            }
            Some(noise) => self.draws.iter_mut().for_each(|draw| *draw = self.stream.draw(noise)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noise_and_filter_the_velocity_is_the_difference_of_the_positions() {
        let mut encoder = Encoder::new(1, None, LowPass::open(), 0.002);
        encoder.begin(&[0.5], &[7.0], &[9.0], &[0.1], Stream::new("test"));
        assert_eq!((encoder.position(), encoder.velocity()), (&[0.6][..], &[9.0][..]));
        assert_eq!(encoder.difference(), [7.0]);
        encoder.sample(&[0.51]);
        assert!((encoder.position()[0] - 0.61).abs() < 1e-12 && (encoder.velocity()[0] - 5.0).abs() < 1e-9);
        assert_eq!(encoder.difference(), encoder.velocity());
    }

    #[test]
    fn noise_has_the_spread_that_was_asked_for_and_repeats_with_its_stream() {
        let run = || {
            let noise = Sampler::Normal([0.0, 1e-4]);
            let mut encoder = Encoder::new(3, Some(noise), LowPass::new(4.0, 0.0005), 0.0005);
            encoder.begin(&[0.0; 3], &[0.0; 3], &[0.0; 3], &[0.0; 3], Stream::new("test"));
            let mut squares = [0.0; 2];
            for _ in 0..20_000 {
                encoder.sample(&[0.0; 3]);
                squares[0] += encoder.position().iter().map(|x| x * x).sum::<f64>() / 60_000.0;
                squares[1] += encoder.velocity().iter().map(|x| x * x).sum::<f64>() / 60_000.0;
            }
            squares.map(f64::sqrt)
        };
        let [position, velocity] = run();
        assert!((position / 1e-4 - 1.0).abs() < 0.02);
        // White position noise s, differenced and filtered: variance 2 s^2 a^2 / (dt^2 (2 - a)).
        let share = LowPass::new(4.0, 0.0005).share();
        let expected = 1e-4 * share / 0.0005 * (2.0 / (2.0 - share)).sqrt();
        assert!((velocity / expected - 1.0).abs() < 0.03);
        assert_eq!(run(), [position, velocity]);
    }
}
