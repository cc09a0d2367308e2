//! The randomization `joint_offset`.

use super::{Draft, Randomization};
use crate::robot::selector::matches;
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct JointOffset = "joint_offset" {
        /// Offset of a joint's measured position.
        #[range(-3.2, 3.2)]
        offset: Sampled<Radian>,
        /// Names of the joints, in which `*` matches any letters.
        #[default("[\"*\"]")]
        joints: Vec<String>,
    }
}

impl Randomization for JointOffset {
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
    use crate::spec::Sampler;

    #[test]
    fn every_selected_encoder_is_shifted() {
        let mut draft = draft();
        let all = JointOffset { offset: Sampler::Constant(-0.03), joints: vec!["*".to_owned()] };
        all.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.joint_offset, vec![-0.03; 2]);
        let second = JointOffset {
            offset: Sampler::Constant(0.03),
            joints: vec![draft.robot.links[1].joint.name.clone()],
        };
        second.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.joint_offset, vec![-0.03, 0.0]);
    }
}
