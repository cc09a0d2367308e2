//! The randomization `joint_offset`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::robot::selector::matches;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "joint_offset",
        since: Edition::ONE,
        doc: include_str!("joint_offset.md"),
        params: &[
            Param::required("offset", Ty::Sampler(Dimension::ANGLE))
                .range(-3.2, 3.2)
                .doc("Shift of a joint's measured position."),
            Param::default("joints", Ty::List(&Ty::Text), "[\"*\"]")
                .doc("Names of the joints, in which `*` stands for any letters."),
        ],
        needs: &[],
    },
    build: |section| Box::new(Term { offset: section.sampler("offset"), joints: section.texts("joints") }),
};

struct Term {
    offset: Sampler,
    joints: Vec<String>,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        for (link, offset) in draft.robot.links.iter().zip(&mut draft.joint_offset) {
            let drawn = stream.draw(&self.offset);
            if self.joints.iter().any(|selector| matches(selector, &link.joint.name)) {
                *offset += drawn;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn every_selected_encoder_is_shifted() {
        let mut draft = draft();
        let all = Term { offset: Sampler::Constant(-0.03), joints: vec!["*".to_owned()] };
        all.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.joint_offset, vec![-0.03; 2]);
        let second = Term { offset: Sampler::Constant(0.03), joints: vec![draft.robot.links[1].joint.name.clone()] };
        second.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.joint_offset, vec![-0.03, 0.0]);
    }
}
