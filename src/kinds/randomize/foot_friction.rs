//! The randomization `foot_friction`.

use super::{Draft, PerFoot, Randomization, factors};
use crate::spec::typed::prelude::*;
use crate::stream::Stream;

kind! {
    pub struct FootFriction = "foot_friction" {
        /// Factor on the friction of the sole.
        #[range(1e-3, 1e3)]
        scale: Sampled<One>,
        /// Whether each foot has its own factor or both share one.
        #[default("\"foot\"")]
        per: PerFoot,
    }
}

impl Randomization for FootFriction {
    fn apply(&self, draft: &mut Draft, stream: &mut Stream) {
        let factors = factors(&self.scale, self.per == PerFoot::Robot, draft.robot.feet.len(), stream);
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
            let per = if shared { PerFoot::Robot } else { PerFoot::Foot };
            FootFriction { scale: Sampler::Uniform([0.5, 1.5]), per }
                .apply(&mut draft, &mut Stream::new("test"));
            draft.robot.feet.map(|foot| foot.friction)
        };
        let [left, right] = grips(true);
        assert_eq!(right, 0.5 * left);
        let [left, right] = grips(false);
        assert!((right - 0.5 * left).abs() > 1e-3 && (0.25..=0.75).contains(&right));
    }
}
