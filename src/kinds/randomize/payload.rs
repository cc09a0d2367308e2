//! The randomization `payload`.

use super::{Draft, Randomization};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct Payload = "payload" {
        /// The added mass.
        #[range(0.0, 1e4)]
        mass: Sampled<Kilogram>,
    }
}

impl Randomization for Payload {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.robot.base.mass += stream.draw(&self.mass);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn the_base_carries_the_mass() {
        let mut draft = draft();
        let before = draft.robot.total_mass();
        Payload { mass: Sampler::Constant(12.0) }.apply(&mut draft, &mut Stream::new("test"));
        assert!((draft.robot.total_mass() - before - 12.0).abs() < 1e-12);
    }
}
