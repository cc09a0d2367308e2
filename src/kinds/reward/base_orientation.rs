//! The reward term `base_orientation`.

use super::kernel;
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "base_orientation",
        since: Edition::ONE,
        doc: include_str!("base_orientation.md"),
        params: &[Param::required("k", Ty::Quantity(Dimension::PER_ANGLE))
            .range(0.0, 1e9)
            .doc("One over the angle at which the term has fallen to 37 %.")],
        needs: &[Signal::BaseOrientation, Signal::Reference],
    },
    build: |section| Box::new(Term { k: section.si("k") }),
};

struct Term {
    k: f64,
}

impl Reward for Term {
    fn value(&self, signals: &Signals) -> f64 {
        let (a, b) = (signals.base_orientation, signals.reference.base_orientation);
        // The rotation conj(b) a; its vector part and scalar part give the angle without loss near zero.
        let scalar = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
        let vector = [
            b[0] * a[1] - b[1] * a[0] - b[2] * a[3] + b[3] * a[2],
            b[0] * a[2] - b[2] * a[0] - b[3] * a[1] + b[1] * a[3],
            b[0] * a[3] - b[3] * a[0] - b[1] * a[2] + b[2] * a[1],
        ];
        let sine = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        kernel(self.k, 2.0 * libm::atan2(sine, scalar.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_tenth_of_a_radian_of_roll_costs_exp_of_minus_1_32() {
        let mut world = Sample::new(1);
        world.base_orientation = [libm::cos(0.05), libm::sin(0.05), 0.0, 0.0];
        assert!((Term { k: 13.2 }.value(&world.signals()) - libm::exp(-1.32)).abs() < 1e-12);
    }

    #[test]
    fn a_quaternion_and_its_negative_are_the_same_attitude() {
        let mut world = Sample::new(1);
        world.base_orientation = [-1.0, 0.0, 0.0, 0.0];
        assert_eq!(Term { k: 13.2 }.value(&world.signals()), 1.0);
    }

    #[test]
    fn the_angle_is_measured_from_the_leaning_reference() {
        let mut world = Sample::new(1);
        world.base_orientation = [libm::cos(0.2), 0.0, libm::sin(0.2), 0.0];
        world.reference.base_orientation = [libm::cos(0.04), 0.0, libm::sin(0.04), 0.0];
        assert!((Term { k: 1.0 }.value(&world.signals()) - libm::exp(-0.32)).abs() < 1e-12);
    }
}
