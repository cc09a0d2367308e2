//! The reward term `velocity_tracking`.

use super::{kernel, squared_error};
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "velocity_tracking",
        since: Edition::ONE,
        doc: include_str!("velocity_tracking.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_VELOCITY_SQUARED))
            .range(0.0, 1e9)
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
        kernel(self.k, squared_error(&signals.base_velocity, signals.command_speed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn forward_error_and_side_speed_add_up_in_square() {
        let mut world = Sample::new(1);
        world.command_speed = 0.5;
        world.base_velocity = [0.2, -0.4, 9.0];
        assert!((Term { k: 3.0 }.value(&world.signals()) - libm::exp(-0.75)).abs() < 1e-12);
    }
}
