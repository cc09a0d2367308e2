//! The randomization `motor_constant`.

use super::{Draft, Factors, PER_JOINT, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "motor_constant",
        since: Edition::ONE,
        doc: include_str!("motor_constant.md"),
        params: &[scale("Factor on the torque."), PER_JOINT],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.motor.len(), stream);
        for ((motor, link), factor) in draft.motor.iter_mut().zip(&mut draft.robot.links).zip(factors) {
            *motor *= factor;
            // The current is limited, so the limit of the torque is scaled with it.
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
        Term(Factors { scale: Sampler::Constant(1.1), shared: false }).apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.motor, vec![1.1; 2]);
        assert_eq!(draft.robot.effort_limits(), vec![100.0 * 1.1; 2]);
    }
}
