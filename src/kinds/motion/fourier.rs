//! Fourier series of periodic signals: smooth copies of sampled joint angles with exact derivatives.

use std::f64::consts::TAU;

/// A truncated Fourier series over a phase in `[0, 1)`.
#[derive(Clone, Debug)]
pub(super) struct Series {
    mean: f64,
    /// Cosine and sine amplitude of harmonic `k + 1`.
    amplitudes: Vec<[f64; 2]>,
}

impl Series {
    /// The least-squares fit of equally spaced samples of one cycle with this many harmonics.
    pub(super) fn fit(samples: &[f64], harmonics: usize) -> Self {
        let count = samples.len() as f64;
        let amplitudes = (1..=harmonics).map(|k| {
            let mut sums = [0.0; 2];
            for (index, sample) in samples.iter().enumerate() {
                let (sine, cosine) = libm::sincos(TAU * (k * index % samples.len()) as f64 / count);
                sums[0] += sample * cosine;
                sums[1] += sample * sine;
            }
            sums.map(|sum| 2.0 * sum / count)
        });
        Self { mean: samples.iter().sum::<f64>() / count, amplitudes: amplitudes.collect() }
    }

    /// The value and its first and second derivative with respect to the phase.
    pub(super) fn at(&self, phase: f64) -> [f64; 3] {
        let mut value = [self.mean, 0.0, 0.0];
        for (index, [a, b]) in self.amplitudes.iter().enumerate() {
            let pulse = TAU * (index + 1) as f64;
            let (sine, cosine) = libm::sincos(pulse * phase);
            value[0] += a * cosine + b * sine;
            value[1] += pulse * (b * cosine - a * sine);
            value[2] -= pulse * pulse * (a * cosine + b * sine);
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_two_harmonics_is_recovered_with_its_derivatives() {
        let signal = |s: f64| 0.3 + libm::sin(TAU * s) - 0.2 * libm::cos(2.0 * TAU * s);
        let samples: Vec<f64> = (0..64).map(|i| signal(i as f64 / 64.0)).collect();
        let series = Series::fit(&samples, 2);
        let [value, rate, acceleration] = series.at(0.37);
        assert!((value - signal(0.37)).abs() < 1e-12);
        let step = 1e-5;
        assert!((rate - (signal(0.37 + step) - signal(0.37 - step)) / (2.0 * step)).abs() < 1e-6);
        let second = (signal(0.37 + step) - 2.0 * signal(0.37) + signal(0.37 - step)) / (step * step);
        assert!((acceleration - second).abs() < 1e-3);
    }
}
