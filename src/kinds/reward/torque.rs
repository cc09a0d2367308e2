//! The reward term `torque`.

use super::kernel;
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "torque",
        since: Edition::ONE,
        doc: include_str!("torque.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_TORQUE))
            .range(1e-9, 1e9)
            .doc("One over the torque norm at which the term has fallen to 37 %.")],
        needs: &[Signal::Torque],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
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
        assert!((Term { k: 0.01 }.value(&world.signals()) - libm::exp(-0.5)).abs() < 1e-12);
    }
}
