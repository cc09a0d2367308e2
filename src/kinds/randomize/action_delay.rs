//! The randomization `action_delay`.

use super::{Draft, Randomization};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct ActionDelay = "action_delay" {
        /// Factor on `action.delay`.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
    }
}

impl Randomization for ActionDelay {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.delay *= stream.draw(&self.scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn the_delay_is_scaled() {
        let mut draft = draft();
        ActionDelay { scale: Sampler::Constant(0.5) }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.delay, 0.5);
    }
}
