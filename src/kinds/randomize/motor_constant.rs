//! The randomization `motor_constant`.

use super::{Draft, Randomization, RandomizationKind, factors};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "motor_constant",
        since: Edition::ONE,
        doc: include_str!("motor_constant.md"),
        params: &[
            Param::required("scale", Ty::Sampler(Dimension::NONE)).range(1e-3, 1e3).doc("Factor on the torque."),
            Param::default("per", Ty::Choice(&["joint", "robot"]), "\"joint\"")
                .doc("Whether every joint has its own draw or the robot has one for all."),
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
        let factors = factors(&self.scale, self.shared, draft.motor.len(), stream);
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

    #[test]
    fn every_motor_is_scaled() {
        let mut draft = draft();
        Term { scale: Sampler::Constant(1.1), shared: false }.apply(&mut draft, &mut Stream::new("test"));
        assert_eq!(draft.motor, vec![1.1; 2]);
        assert_eq!(draft.robot.effort_limits(), vec![100.0 * 1.1; 2]);
    }
}
