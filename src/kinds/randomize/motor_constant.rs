//! The randomization `motor_constant`.

use super::{Draft, PerJoint, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct MotorConstant = "motor_constant" {
        /// Factor on the torque.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether every joint has its own factor or all share one.
        #[default("\"joint\"")]
        per: PerJoint,
    }
}

impl Randomization for MotorConstant {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerJoint::Robot, draft.motor.len(), stream);
        for ((motor, link), factor) in draft.motor.iter_mut().zip(&mut draft.robot.links).zip(factors) {
            *motor *= factor;
            // The current is limited, so the torque limit scales with the constant.
            link.joint.effort_limit *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn every_motor_is_scaled() {
        let mut draft = draft();
        MotorConstant { scale: Sampler::Constant(1.1), per: PerJoint::Joint }
            .apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.motor, vec![1.1; 2]);
        assert_eq!(draft.robot.effort_limits(), vec![100.0 * 1.1; 2]);
    }
}
