//! The randomization `link_com`.

use super::{Draft, PerLink, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct LinkCom = "link_com" {
        /// Factor on the centre of mass.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether every link has its own factor or all share one.
        #[default("\"link\"")]
        per: PerLink,
    }
}

impl Randomization for LinkCom {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerLink::Robot, draft.robot.links.len() + 1, stream);
        draft.bodies().zip(factors).for_each(|(body, factor)| body.com.coords *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn every_centre_moves_away_from_its_frame() {
        let mut draft = draft();
        let before = draft.robot.clone();
        LinkCom { scale: Sampler::Constant(1.5), per: PerLink::Link }
            .apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.base.com.coords, before.base.com.coords * 1.5);
    }
}
