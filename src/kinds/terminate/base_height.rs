//! The termination `base_height`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

kind! {
    pub struct BaseHeight = "base_height", needs [BaseHeight] {
        /// The episode ends if the base origin is less than this above the ground.
        #[range(0.0, 10.0)]
        below: Quantified<Metre>,
    }
}

impl Termination for BaseHeight {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.base_height < self.below * signals.stature
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn the_bound_itself_is_still_standing() {
        let mut world = Sample::new(1);
        world.base_height = 0.6;
        assert!(!BaseHeight { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
        world.base_height = 0.599;
        assert!(BaseHeight { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
    }

    #[test]
    fn the_bound_follows_the_legs_of_the_episode() {
        let mut world = Sample::new(1);
        (world.base_height, world.stature) = (0.55, 0.9);
        assert!(!BaseHeight { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
        world.base_height = 0.53;
        assert!(BaseHeight { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
    }
}
