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
        draft.robot.stretch_legs(stream.draw(&self.scale));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;

    #[test]
    fn joints_below_the_hip_move_and_the_hip_stays() {
        let before = robot("tocabi");
        let mut draft = Draft::new(before.clone(), 1.0, 16.0);
        Term { scale: Sampler::Constant(1.3) }.apply(&mut draft, &mut Stream::new("test"));
        let origin = |robot: &crate::robot::Robot, link: usize| robot.links[link].joint.origin.translation.vector;
        assert_eq!(origin(&draft.robot, 0), origin(&before, 0));
        assert!((origin(&draft.robot, 3) - origin(&before, 3) * 1.3).norm() < 1e-12);
        // Thigh and shank of 0.35 m each stand at 0.24 rad and 0.36 rad to the vertical.
        let taller = 0.3 * 0.35 * (libm::cos(0.24) + libm::cos(0.36));
        assert!((draft.robot.standing_height - before.standing_height - taller).abs() < 1e-9);
    }
}
