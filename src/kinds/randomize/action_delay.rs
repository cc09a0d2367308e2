//! The randomization `action_delay`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "action_delay",
        since: Edition::ONE,
        doc: include_str!("action_delay.md"),
        params: &[Param::required("scale", Ty::Sampler(Dimension::NONE))
            .range(1e-3, 1e3)
            .doc("Factor on `action.delay`.")],
        needs: &[],
    },
    build: |section| Box::new(Term { scale: section.sampler("scale") }),
};

struct Term {
    scale: Sampler,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.delay *= stream.draw(&self.scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn the_delay_is_scaled() {
        let mut draft = draft();
        Term { scale: Sampler::Constant(0.5) }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.delay, 0.5);
    }
}
