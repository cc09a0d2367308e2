//! The randomization `foot_friction`.

use super::{Draft, Factors, Randomization, RandomizationKind, scale};
use crate::kinds::Entry;
use crate::spec::{Edition, Kind, Param, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "foot_friction",
        since: Edition::ONE,
        doc: include_str!("foot_friction.md"),
        params: &[
            scale("Factor on the grip of the sole."),
            Param::default("per", Ty::Choice(&["foot", "robot"]), "\"foot\"")
                .doc("Whether each foot has its own draw or the robot has one for both."),
        ],
        needs: &[],
    },
    build: |section| Box::new(Term(Factors::new(section))),
};

struct Term(Factors);

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = self.0.draw(draft.robot.feet.len(), stream);
        draft.robot.feet.iter_mut().zip(factors).for_each(|(foot, factor)| foot.friction *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;
    use crate::spec::Sampler;

    #[test]
    fn each_foot_has_its_own_grip_unless_they_share_it() {
        let grips = |shared: bool| {
            let mut draft = draft();
            draft.robot.feet[1].friction = 0.5;
            Term(Factors { scale: Sampler::Uniform([0.5, 1.5]), shared }).apply(&mut draft, &mut Stream::new("test"));
            draft.robot.feet.map(|foot| foot.friction)
        };
        let [left, right] = grips(true);
        assert_eq!(right, 0.5 * left);
        let [left, right] = grips(false);
        assert!((right - 0.5 * left).abs() > 1e-3 && (0.25..=0.75).contains(&right));
    }
}
