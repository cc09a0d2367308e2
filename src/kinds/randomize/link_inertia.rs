//! The randomization `link_inertia`.

use super::{Draft, Randomization, RandomizationKind, factors};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "link_inertia",
        since: Edition::ONE,
        doc: include_str!("link_inertia.md"),
        params: &[
            Param::required("scale", Ty::Sampler(Dimension::NONE))
                .range(1e-3, 1e3)
                .doc("Factor on the inertia tensor."),
            Param::default("per", Ty::Choice(&["link", "robot"]), "\"link\"")
                .doc("Whether every link has its own draw or the robot has one for all."),
        ],
        needs: &[],
    },
    build: |section| Box::new(Term { scale: section.sampler("scale"), shared: section.text("per") == "robot" }),
};

struct Term {
    scale: Sampler,
    shared: bool,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.shared, draft.robot.links.len() + 1, stream);
        draft.bodies().zip(factors).for_each(|(body, factor)| body.inertia *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn every_tensor_is_scaled() {
        let mut draft = draft();
        let before = draft.robot.clone();
        Term { scale: Sampler::Constant(1.5), shared: false }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.links[1].body.inertia, before.links[1].body.inertia * 1.5);
    }
}
