//! The initial state `default_pose`.

use crate::spec::typed::prelude::*;

kind! {
    pub struct DefaultPose = "default_pose" {
        /// Start phases, drawn with equal probability; evaluations take them in turn.
        #[range(0.0, 1.0)]
        #[default("[0.0]")]
        phases: Vec<f64>,
        /// Added to each joint position of the standing starts, like the `perturbation` of evaluations;
        /// without it all standing starts are the same.
        #[range(-3.2, 3.2)]
        standing_noise: Option<Sampled<Radian>>,
    }
}
