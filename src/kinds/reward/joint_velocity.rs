//! The reward term `joint_velocity`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointVelocity = "joint_velocity", needs [Joints] {
        /// Sharpness of the kernel.
        #[range(1e-9, 1e9)]
        k: Quantified<PerSquareAngularVelocity>,
    }
}

impl Reward for JointVelocity {
    fn value(&self, signals: &Signals) -> f64 {
        kernel(self.k, signals.velocity.iter().map(|rate| rate * rate).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn six_and_eight_rad_per_s_cost_exp_of_minus_one() {
        let mut world = Sample::new(2);
        world.velocity = vec![6.0, -8.0];
        assert!((JointVelocity { k: 0.01 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
