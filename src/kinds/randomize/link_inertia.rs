//! The randomization `link_inertia`.

use super::{Draft, PerLink, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct LinkInertia = "link_inertia" {
        /// Factor on the inertia tensor.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether every link has its own factor or all share one.
        #[default("\"link\"")]
        per: PerLink,
    }
}

impl Randomization for LinkInertia {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerLink::Robot, draft.robot.links.len() + 1, stream);
        draft.bodies().zip(factors).for_each(|(body, factor)| body.inertia *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn every_tensor_is_scaled() {
        let mut draft = draft();
        let before = draft.robot.clone();
        LinkInertia { scale: Sampler::Constant(1.5), per: PerLink::Link }
            .apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.links[1].body.inertia, before.links[1].body.inertia * 1.5);
    }
}
