//! The randomization `link_inertia`.

use super::{Draft, Factors, PER_LINK, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "link_inertia",
        since: Edition::ONE,
        doc: include_str!("link_inertia.md"),
        params: &[scale("Factor on the inertia tensor."), PER_LINK],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.robot.links.len() + 1, stream);
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
        Term(Factors { scale: Sampler::Constant(1.5), shared: false }).apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.links[1].body.inertia, before.links[1].body.inertia * 1.5);
    }
}
