//! The reward term `joint_tracking`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointTracking = "joint_tracking", needs [Joints, Reference] {
        /// Sharpness of the kernel.
        #[range(1e-9, 1e9)]
        k: Quantified<PerSquareRadian>,
    }
}

impl Reward for JointTracking {
    fn value(&self, signals: &Signals) -> f64 {
        let error = signals.position.iter().zip(&signals.reference.position);
        kernel(self.k, error.map(|(q, reference)| (q - reference) * (q - reference)).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn errors_of_0_3_and_0_4_rad_make_a_squared_norm_of_a_quarter() {
        let mut world = Sample::new(2);
        world.position = vec![0.5, -0.1];
        world.reference.position = vec![0.2, 0.3];
        assert!((JointTracking { k: 4.0 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
