//! The termination `joint_error`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointError = "joint_error", needs [Joints, Reference] {
        /// The episode ends if any joint is further than this from the reference.
        #[range(0.0, 10.0)]
        above: Quantified<Radian>,
    }
}

impl Termination for JointError {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        let mut pairs = signals.position.iter().zip(&signals.reference.position);
        pairs.any(|(position, reference)| (position - reference).abs() > self.above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn one_joint_is_enough() {
        let mut world = Sample::new(2);
        world.position = vec![0.0, -0.51];
        assert!(JointError { above: 0.5 }.ends(&world.signals(), &mut [0.0; 2]));
        assert!(!JointError { above: 0.52 }.ends(&world.signals(), &mut [0.0; 2]));
    }
}
