//! The reward term `joint_velocity_change`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointVelocityChange = "joint_velocity_change", needs [Joints] {
        /// Sharpness of the kernel.
        #[range(1e-9, 1e9)]
        k: Quantified<PerSquareAngularVelocity>,
    }
}

impl Reward for JointVelocityChange {
    fn value(&self, signals: &Signals) -> f64 {
        let change = signals.velocity.iter().zip(signals.previous_velocity);
        kernel(self.k, change.map(|(now, before)| (now - before) * (now - before)).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn changes_of_0_3_and_0_1_rad_per_s_have_a_squared_norm_of_a_tenth() {
        let mut world = Sample::new(2);
        world.velocity = vec![1.3, -0.9];
        world.previous_velocity = vec![1.0, -1.0];
        assert!((JointVelocityChange { k: 20.0 }.value(&world.signals()) - libm::exp(-2.0)).abs() < 1e-12);
    }
}
