//! The reward term `base_orientation`.

use super::kernel;
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

choice! {
    /// Distance between two orientations.
    pub enum Difference {
        /// The angle between them in rad.
        Angle = "angle",
        /// The norm of the difference of their quaternions, with the nearer of both signs: 2 sin(angle / 4).
        Quaternion = "quaternion",
    }
}

kind! {
    pub struct BaseOrientation = "base_orientation", needs [BaseOrientation, Reference] {
        /// One over the angle at which the term has fallen to 37 %.
        #[range(1e-9, 1e9)]
        k: Quantified<PerRadian>,
        /// Distance between the two orientations: their angle (default), or the norm of the difference of
        /// their quaternions, as printed in the paper, which is about half of it.
        difference: Option<Difference>,
    }
}

impl Reward for BaseOrientation {
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
        let angle = 2.0 * libm::atan2(sine, scalar.abs());
        kernel(
            self.k,
            match self.difference {
                None | Some(Difference::Angle) => angle,
                Some(Difference::Quaternion) => 2.0 * libm::sin(angle / 4.0),
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    fn term(k: f64) -> BaseOrientation {
        BaseOrientation { k, difference: None }
    }

    #[test]
    fn a_tenth_of_a_radian_of_roll_costs_exp_of_minus_1_32() {
        let mut world = Sample::new(1);
        world.base_orientation = [libm::cos(0.05), libm::sin(0.05), 0.0, 0.0];
        assert!((term(13.2).value(&world.signals()) - libm::exp(-1.32)).abs() < 1e-12);
    }

    #[test]
    fn a_quaternion_and_its_negative_are_the_same_attitude() {
        let mut world = Sample::new(1);
        world.base_orientation = [-1.0, 0.0, 0.0, 0.0];
        assert_eq!(term(13.2).value(&world.signals()), 1.0);
    }

    #[test]
    fn the_angle_is_measured_from_the_leaning_reference() {
        let mut world = Sample::new(1);
        world.base_orientation = [libm::cos(0.2), 0.0, libm::sin(0.2), 0.0];
        world.reference.base_orientation = [libm::cos(0.04), 0.0, libm::sin(0.04), 0.0];
        assert!((term(1.0).value(&world.signals()) - libm::exp(-0.32)).abs() < 1e-12);
    }

    #[test]
    fn as_printed_the_nearer_of_two_quaternions_counts() {
        let mut world = Sample::new(1);
        let (a, b) =
            ([libm::cos(0.2), libm::sin(0.2), 0.0, 0.0], [libm::cos(0.05), 0.0, libm::sin(0.05), 0.0]);
        world.base_orientation = a.map(|part| -part);
        world.reference.base_orientation = b;
        let distance = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let printed = BaseOrientation { k: 13.2, difference: Some(Difference::Quaternion) };
        assert!((printed.value(&world.signals()) - libm::exp(-13.2 * distance)).abs() < 1e-12);
    }
}
