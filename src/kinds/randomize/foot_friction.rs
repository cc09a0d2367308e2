//! The randomization `foot_friction`.

use super::{Draft, Randomization, RandomizationKind, factors};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "foot_friction",
        since: Edition::ONE,
        doc: include_str!("foot_friction.md"),
        params: &[
            Param::required("scale", Ty::Sampler(Dimension::NONE))
                .range(1e-3, 1e3)
                .doc("Factor on the grip of the sole."),
            Param::default("per", Ty::Choice(&["foot", "robot"]), "\"foot\"")
                .doc("Whether each foot has its own draw or the robot has one for both."),
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
        let factors = factors(&self.scale, self.shared, draft.robot.feet.len(), stream);
        draft.robot.feet.iter_mut().zip(factors).for_each(|(foot, factor)| foot.friction *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn each_foot_has_its_own_grip_unless_they_share_it() {
        let grips = |shared: bool| {
            let mut draft = draft();
            draft.robot.feet[1].friction = 0.5;
            Term { scale: Sampler::Uniform([0.5, 1.5]), shared }.apply(&mut draft, &mut Stream::new("test"));
            draft.robot.feet.map(|foot| foot.friction)
        };
        let [left, right] = grips(true);
        assert_eq!(right, 0.5 * left);
        let [left, right] = grips(false);
        assert!((right - 0.5 * left).abs() > 1e-3 && (0.25..=0.75).contains(&right));
    }
}
