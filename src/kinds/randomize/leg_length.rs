//! The randomization `leg_length`.

use super::{Draft, Randomization};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct LegLength = "leg_length" {
        /// Factor on the length of the legs.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
    }
}

impl Randomization for LegLength {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        draft.robot.stretch_legs(stream.draw(&self.scale));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;
    use crate::spec::Sampler;

    #[test]
    fn joints_below_the_hip_move_and_the_hip_stays() {
        let before = robot("tocabi");
        let mut draft = Draft::new(before.clone(), 1.0, 16.0);
        LegLength { scale: Sampler::Constant(1.3) }.apply(&mut draft, &mut Stream::new("test"));
        let origin =
            |robot: &crate::robot::Robot, link: usize| robot.links[link].joint.origin.translation.vector;
        assert_eq!(origin(&draft.robot, 0), origin(&before, 0));
        assert!((origin(&draft.robot, 3) - origin(&before, 3) * 1.3).norm() < 1e-12);
        // Thigh and shank of 0.35 m each are inclined by 0.24 rad and 0.36 rad.
        let taller = 0.3 * 0.35 * (libm::cos(0.24) + libm::cos(0.36));
        assert!((draft.robot.standing_height - before.standing_height - taller).abs() < 1e-9);
    }
}
