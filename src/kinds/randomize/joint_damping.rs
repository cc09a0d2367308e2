//! The randomization `joint_damping`.

use super::{Draft, Factors, PER_JOINT, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "joint_damping",
        since: Edition::ONE,
        doc: include_str!("joint_damping.md"),
        params: &[scale("Factor on the viscous damping."), PER_JOINT],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.robot.links.len(), stream);
        draft.robot.links.iter_mut().zip(factors).for_each(|(link, factor)| link.joint.damping *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn every_joint_is_scaled() {
        let mut draft = draft();
        let before = draft.robot.clone();
        Term(Factors { scale: Sampler::Constant(1.5), shared: false }).apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.links[0].joint.damping, before.links[0].joint.damping * 1.5);
    }
}
