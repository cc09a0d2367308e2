//! The randomization `joint_damping`.

use super::{Draft, PerJoint, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct JointDamping = "joint_damping" {
        /// Factor on the viscous damping.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether every joint has its own factor or all share one.
        #[default("\"joint\"")]
        per: PerJoint,
    }
}

impl Randomization for JointDamping {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerJoint::Robot, draft.robot.links.len(), stream);
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
        JointDamping { scale: Sampler::Constant(1.5), per: PerJoint::Joint }
            .apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.robot.links[0].joint.damping, before.links[0].joint.damping * 1.5);
    }
}
