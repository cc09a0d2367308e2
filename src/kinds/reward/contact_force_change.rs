//! The reward term `contact_force_change`.

use super::{kernel, norm};
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct ContactForceChange = "contact_force_change", needs [FootForce] {
        /// One over the change at which the term has fallen to 37 %.
        #[range(1e-9, 1e9)]
        k: Quantified<PerNewton>,
    }
}

impl Reward for ContactForceChange {
    fn value(&self, signals: &Signals) -> f64 {
        let change = |foot: usize| {
            let (now, before) = (signals.foot_force[foot], signals.previous_foot_force[foot]);
            norm(&[now[0] - before[0], now[1] - before[1], now[2] - before[2]])
        };
        kernel(self.k, change(0) + change(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn the_changes_of_both_feet_add_up() {
        let mut world = Sample::new(1);
        world.foot_force = [[0.0, 0.0, 1000.0], [30.0, 0.0, 0.0]];
        world.previous_foot_force = [[0.0, 0.0, 50.0], [0.0, 40.0, 0.0]];
        assert!((ContactForceChange { k: 0.0005 }.value(&world.signals()) - libm::exp(-0.5)).abs() < 1e-12);
    }
}
