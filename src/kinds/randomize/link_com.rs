//! The randomization `link_com`.

use super::{Draft, Factors, PER_LINK, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "link_com",
        since: Edition::ONE,
        doc: include_str!("link_com.md"),
        params: &[scale("Factor on the centre of mass."), PER_LINK],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.robot.links.len() + 1, stream);
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
        Term(Factors { scale: Sampler::Constant(1.5), shared: false }).apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.base.com.coords, before.base.com.coords * 1.5);
    }
}
