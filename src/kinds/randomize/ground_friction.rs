//! The randomization `ground_friction`.

use super::{Draft, Randomization};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct GroundFriction = "ground_friction" {
        /// Factor on `terrain.friction`.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
    }
}

impl Randomization for GroundFriction {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.friction *= stream.draw(&self.scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn the_friction_is_scaled() {
        let mut draft = draft();
        GroundFriction { scale: Sampler::Constant(0.25) }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.friction, 0.25);
    }
}
