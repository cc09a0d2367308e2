//! The reward term `joint_velocity`.

use super::kernel;
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "joint_velocity",
        since: Edition::ONE,
        doc: include_str!("joint_velocity.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_ANGULAR_VELOCITY_SQUARED))
            .range(1e-9, 1e9)
            .doc("Sharpness of the kernel.")],
        needs: &[Signal::Joints],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
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
        assert!((Term { k: 0.01 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
