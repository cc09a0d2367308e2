//! The termination `self_collision`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

kind! {
    pub struct SelfCollision = "self_collision", needs [SelfCollision] {}
}

impl Termination for SelfCollision {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.self_collision
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_knee_inside_the_other_ends_the_episode() {
        let mut world = Sample::new(1);
        assert!(!SelfCollision {}.ends(&world.signals(), &mut [0.0; 2]));
        world.self_collision = true;
        assert!(SelfCollision {}.ends(&world.signals(), &mut [0.0; 2]));
    }
}
