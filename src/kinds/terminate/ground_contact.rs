//! The termination `ground_contact`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

kind! {
    pub struct GroundContact = "ground_contact", needs [BodyContact] {}
}

impl Termination for GroundContact {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.body_contact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_knee_on_the_ground_ends_the_episode() {
        let mut world = Sample::new(1);
        assert!(!GroundContact {}.ends(&world.signals(), &mut [0.0; 2]));
        world.body_contact = true;
        assert!(GroundContact {}.ends(&world.signals(), &mut [0.0; 2]));
    }
}
