//! The reward term `joint_tracking`.

use super::kernel;
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "joint_tracking",
        since: Edition::ONE,
        doc: include_str!("joint_tracking.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_ANGLE_SQUARED))
            .range(1e-9, 1e9)
            .doc("Sharpness of the kernel.")],
        needs: &[Signal::Joints, Signal::Reference],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
    fn value(&self, signals: &Signals) -> f64 {
        let error = signals.position.iter().zip(&signals.reference.position);
        kernel(self.k, error.map(|(q, reference)| (q - reference) * (q - reference)).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn errors_of_0_3_and_0_4_rad_make_a_squared_norm_of_a_quarter() {
        let mut world = Sample::new(2);
        world.position = vec![0.5, -0.1];
        world.reference.position = vec![0.2, 0.3];
        assert!((Term { k: 4.0 }.value(&world.signals()) - libm::exp(-1.0)).abs() < 1e-12);
    }
}
