//! The randomization `leg_length`.

use super::{Draft, Randomization, RandomizationKind};
use crate::kinds::Entry;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Sampler, Ty};
use crate::stream::Stream;

/// The registry entry.
pub static KIND: RandomizationKind = Entry {
    kind: Kind {
        name: "leg_length",
        since: Edition::ONE,
        doc: include_str!("leg_length.md"),
        params: &[Param::required("scale", Ty::Sampler(Dimension::NONE))
            .range(1e-3, 1e3)
            .doc("Factor on the length of the legs.")],
        needs: &[],
    },
    build: |section| Box::new(Term { scale: section.sampler("scale") }),
};

struct Term {
    scale: Sampler,
}

impl Randomization for Term {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factor = stream.draw(&self.scale);
        let feet = [draft.robot.feet[0].link, draft.robot.feet[1].link];
        for (index, link) in draft.robot.links.iter_mut().enumerate() {
            if link.parent.is_some() {
                link.joint.origin.translation.vector *= factor;
            }
            if !feet.contains(&index) {
                link.body.com.coords *= factor;
                link.body.collisions.iter_mut().for_each(|collision| collision.pose.translation.vector *= factor);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::sample::draft;

    #[test]
    fn joints_below_the_hip_move_and_the_hip_stays() {
        let mut draft = draft();
        let before = draft.robot.clone();
        Term { scale: Sampler::Constant(1.3) }.apply(&mut draft, &mut Stream::new("test"));
        let origin = |robot: &crate::robot::Robot, link: usize| robot.links[link].joint.origin.translation.vector;
        assert_eq!(origin(&draft.robot, 0), origin(&before, 0));
        assert_eq!(origin(&draft.robot, 1), origin(&before, 1) * 1.3);
    }
}
