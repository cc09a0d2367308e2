//! The reward term `contact_force`.

use super::{kernel, norm};
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct ContactForce = "contact_force", needs [FootForce] {
        /// One over the force at which the term has fallen to 37 %.
        #[range(1e-9, 1e9)]
        k: Quantified<PerNewton>,
    }
}

impl Reward for ContactForce {
    fn value(&self, signals: &Signals) -> f64 {
        kernel(self.k, signals.foot_force.iter().map(norm).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn five_hundred_and_fifteen_hundred_newtons_cost_exp_of_minus_one() {
        let mut world = Sample::new(1);
        world.foot_force = [[300.0, 0.0, 400.0], [0.0, 0.0, 1500.0]];
        assert!((ContactForce { k: 0.0005 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
