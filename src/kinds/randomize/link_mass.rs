//! The randomization `link_mass`.

use super::{Draft, PerLink, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct LinkMass = "link_mass" {
        /// Factor on the mass.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether every link has its own factor or all share one.
        #[default("\"link\"")]
        per: PerLink,
    }
}

impl Randomization for LinkMass {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerLink::Robot, draft.robot.links.len() + 1, stream);
        draft.bodies().zip(factors).for_each(|(body, factor)| body.mass *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn every_mass_is_scaled() {
        let mut draft = draft();
        let before = draft.robot.clone();
        LinkMass { scale: Sampler::Constant(1.5), per: PerLink::Link }
            .apply(&mut draft, &mut Stream::new("test"));
        assert!((draft.robot.total_mass() / before.total_mass() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn one_draw_for_the_robot_keeps_the_ratios_of_the_masses() {
        let (mut shared, mut own) = (draft(), draft());
        let scale = Sampler::Uniform([0.6, 1.4]);
        LinkMass { scale: scale.clone(), per: PerLink::Robot }.apply(&mut shared, &mut Stream::new("test"));
        LinkMass { scale, per: PerLink::Link }.apply(&mut own, &mut Stream::new("test"));
        let ratio = |draft: &Draft| draft.robot.links[0].body.mass / draft.robot.base.mass;
        assert!((ratio(&shared) - ratio(&draft())).abs() < 1e-12);
        assert!((ratio(&own) - ratio(&draft())).abs() > 1e-3);
    }
}
