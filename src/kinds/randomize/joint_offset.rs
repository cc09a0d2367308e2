//! The randomization `joint_offset`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "joint_offset",
        since: Edition::ONE,
        doc: include_str!("joint_offset.md"),
        params: &[Param::required("offset", Ty::Sampler(Dimension::ANGLE)).doc("Shift of a joint's measured position.")],
        needs: &[],
    },
    build: |section| Box::new(Term { offset: section.sampler("offset") }),
};

struct Term {
    offset: Sampler,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.joint_offset.iter_mut().for_each(|offset| *offset += stream.draw(&self.offset));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn every_encoder_is_shifted() {
        let mut draft = draft();
        Term { offset: Sampler::Constant(-0.03) }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.joint_offset, vec![-0.03; 2]);
    }
}
