//! The reward term `torque`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Torque = "torque", needs [Torque] {
        /// One over the torque norm at which the term has fallen to 37 %.
        #[range(1e-9, 1e9)]
        k: Quantified<PerNewtonMetre>,
    }
}

impl Reward for Torque {
    fn value(&self, signals: &Signals) -> f64 {
        kernel(self.k, signals.torque.iter().map(|torque| torque * torque).sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_torque_norm_of_fifty_costs_exp_of_minus_a_half() {
        let mut world = Sample::new(2);
        world.torque = vec![-30.0, 40.0];
        assert!((Torque { k: 0.01 }.value(&world.signals()) - libm::exp(-0.5)).abs() < 1e-12);
    }
}
