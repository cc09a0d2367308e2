//! The termination `base_tilt`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

kind! {
    pub struct BaseTilt = "base_tilt", needs [BaseOrientation] {
        /// The episode ends if the base's z axis tilts by more than this.
        #[range(0.0, 3.2)]
        above: Quantified<Radian>,
    }
}

impl Termination for BaseTilt {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        let [_, x, y, _] = signals.base_orientation;
        // The z component of the rotated z axis.
        1.0 - 2.0 * (x * x + y * y) < libm::cos(self.above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn pitch_counts_and_yaw_does_not() {
        let term = BaseTilt { above: 0.6 };
        let mut world = Sample::new(1);
        for (angle, ends) in [(0.59f64, false), (0.61, true), (-0.61, true)] {
            world.base_orientation = [libm::cos(angle / 2.0), 0.0, libm::sin(angle / 2.0), 0.0];
            assert_eq!(term.ends(&world.signals(), &mut [0.0; 2]), ends);
        }
        world.base_orientation = [0.0, 0.0, 0.0, 1.0];
        assert!(!term.ends(&world.signals(), &mut [0.0; 2]));
    }
}
