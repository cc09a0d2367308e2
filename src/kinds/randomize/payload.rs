//! The randomization `payload`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "payload",
        since: Edition::ONE,
        doc: include_str!("payload.md"),
        params: &[Param::required("mass", Ty::Sampler(Dimension::MASS)).range(0.0, 1e4).doc("The mass carried.")],
        needs: &[],
    },
    build: |section| Box::new(Term { mass: section.sampler("mass") }),
};

struct Term {
    mass: Sampler,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.robot.base.mass += stream.draw(&self.mass);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn the_base_carries_the_mass() {
        let mut draft = draft();
        let before = draft.robot.total_mass();
        Term { mass: Sampler::Constant(12.0) }.apply(&mut draft, &mut Stream::new("test"));
        assert!((draft.robot.total_mass() - before - 12.0).abs() < 1e-12);
    }
}
