//! The reward term `mean_velocity_tracking`.

use super::{kernel, squared_error};
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct MeanVelocityTracking = "mean_velocity_tracking", needs [BaseVelocity] {
        /// Sharpness of the kernel.
        #[range(1e-9, 1e9)]
        k: Quantified<PerSquareVelocity>,
    }
}

impl Reward for MeanVelocityTracking {
    fn value(&self, signals: &Signals) -> f64 {
        kernel(self.k, squared_error(&signals.mean_velocity, signals.command_speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn only_the_mean_velocity_counts() {
        let mut world = Sample::new(1);
        world.command_speed = 0.5;
        world.base_velocity = [3.0, 3.0, 3.0];
        world.mean_velocity = [0.3, 0.1, 9.0];
        assert!((MeanVelocityTracking { k: 20.0 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
