//! The randomization `link_mass`.

use super::{Draft, Factors, PER_LINK, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "link_mass",
        since: Edition::ONE,
        doc: include_str!("link_mass.md"),
        params: &[scale("Factor on the mass."), PER_LINK],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.robot.links.len() + 1, stream);
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
        Term(Factors { scale: Sampler::Constant(1.5), shared: false }).apply(&mut draft, &mut Stream::new("test"));
        assert!((draft.robot.total_mass() / before.total_mass() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn one_draw_for_the_robot_keeps_the_ratios_of_the_masses() {
        let (mut shared, mut own) = (draft(), draft());
        let scale = Sampler::Uniform([0.6, 1.4]);
        Term(Factors { scale: scale.clone(), shared: true }).apply(&mut shared, &mut Stream::new("test"));
        Term(Factors { scale, shared: false }).apply(&mut own, &mut Stream::new("test"));
        let ratio = |draft: &Draft| draft.robot.links[0].body.mass / draft.robot.base.mass;
        assert!((ratio(&shared) - ratio(&draft())).abs() < 1e-12);
        assert!((ratio(&own) - ratio(&draft())).abs() > 1e-3);
    }
}
