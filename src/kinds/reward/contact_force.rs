//! The reward term `contact_force`.

use super::{kernel, norm};
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "contact_force",
        since: Edition::ONE,
        doc: include_str!("contact_force.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_FORCE))
            .range(1e-9, 1e9)
            .doc("One over the force at which the term has fallen to 37 %.")],
        needs: &[Signal::FootForce],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
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
        assert!((Term { k: 0.0005 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
