//! The initial state `default_pose`.

use crate::spec::typed::prelude::*;

kind! {
    pub struct DefaultPose = "default_pose" {
        /// Phases to start at, drawn with equal chance; evaluations take them in turn.
        #[range(0.0, 1.0)]
        #[default("[0.0]")]
        phases: Vec<f64>,
        /// Added to each joint position of the standing starts, as evaluations do by their `perturbation`;
        /// without it they are all alike.
        #[range(-3.2, 3.2)]
        standing_noise: Option<Sampled<Radian>>,
    }
}
