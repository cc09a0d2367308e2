//! The reward term `torque_change`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct TorqueChange = "torque_change", needs [Torque] {
        /// One over the change at which the term has fallen to 37 %.
        #[range(1e-9, 1e9)]
        k: Quantified<PerNewtonMetre>,
    }
}

impl Reward for TorqueChange {
    fn value(&self, signals: &Signals) -> f64 {
        let change = signals.torque.iter().zip(signals.previous_torque);
        kernel(self.k, change.map(|(now, before)| (now - before) * (now - before)).sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_change_of_five_newton_metres_costs_a_twentieth_in_the_exponent() {
        let mut world = Sample::new(2);
        world.torque = vec![13.0, -4.0];
        world.previous_torque = vec![10.0, 0.0];
        assert!((TorqueChange { k: 0.01 }.value(&world.signals()) - libm::exp(-0.05)).abs() < 1e-12);
    }
}
