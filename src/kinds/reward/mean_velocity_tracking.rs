//! The reward term `mean_velocity_tracking`.

use super::{kernel, squared_error};
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "mean_velocity_tracking",
        since: Edition::ONE,
        doc: include_str!("mean_velocity_tracking.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_VELOCITY_SQUARED))
            .range(1e-9, 1e9)
            .doc("Sharpness of the kernel.")],
        needs: &[Signal::BaseVelocity],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
    fn value(&self, signals: &Signals) -> f64 {
        kernel(self.k, squared_error(&signals.mean_velocity, signals.command_speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn only_the_mean_velocity_counts() {
        let mut world = Sample::new(1);
        world.command_speed = 0.5;
        world.base_velocity = [3.0, 3.0, 3.0];
        world.mean_velocity = [0.3, 0.1, 9.0];
        assert!((Term { k: 20.0 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
