//! The first-order low-pass filter of the measured joint velocities (docs/explanation/paper.md, A19).

/// `y += a (x - y)` with `a = dt / (RC + dt)`, `RC = 1 / (2 pi f)`: the backward-Euler form that the
/// authors' code uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    share: f64,
}

impl LowPass {
    /// A filter with this cut-off frequency in Hz for samples that are `step` seconds apart.
    pub fn new(cutoff: f64, step: f64) -> Self {
        let time_constant = 1.0 / (std::f64::consts::TAU * cutoff);
        Self { share: step / (time_constant + step) }
    }

    /// No filter: the output is the input.
    pub fn open() -> Self {
        Self { share: 1.0 }
    }

    /// The share `a` of a new sample that enters the output.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// The next output.
    pub fn next(&self, output: f64, input: f64) -> f64 {
        output + self.share * (input - output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_response_is_a_geometric_series() {
        let filter = LowPass::new(4.0, 0.002);
        let mut output = 0.0;
        for count in 1..=100 {
            output = filter.next(output, 1.0);
            assert!((output - (1.0 - (1.0 - filter.share()).powi(count))).abs() < 1e-12);
        }
    }

    #[test]
    fn four_hertz_reach_63_percent_after_40_ms() {
        let filter = LowPass::new(4.0, 1e-5);
        let output = (0..3979).fold(0.0, |output, _| filter.next(output, 1.0));
        assert!((output - (1.0 - libm::exp(-1.0))).abs() < 1e-3);
    }

    #[test]
    fn an_open_filter_passes_everything() {
        assert_eq!(LowPass::open().next(3.0, -7.5), -7.5);
    }
}
