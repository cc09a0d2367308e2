//! The randomization `ground_friction`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "ground_friction",
        since: Edition::ONE,
        doc: include_str!("ground_friction.md"),
        params: &[Param::required("scale", Ty::Sampler(Dimension::NONE))
            .range(1e-3, 1e3)
            .doc("Factor on `terrain.friction`.")],
        needs: &[],
    },
    build: |section| Box::new(Term { scale: section.sampler("scale") }),
};

struct Term {
    scale: Sampler,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.friction *= stream.draw(&self.scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn the_friction_is_scaled() {
        let mut draft = draft();
        Term { scale: Sampler::Constant(0.25) }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.friction, 0.25);
    }
}
