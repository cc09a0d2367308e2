//! The terrain kind `slope`.

use crate::spec::typed::prelude::*;

kind! {
    pub struct Slope = "slope" {
        /// Coulomb friction coefficient between ground and feet.
        #[range(0.0, 10.0)]
        friction: f64,
        /// Angle of the incline; positive is uphill.
        #[range(-0.6, 0.6)]
        angle: Quantified<Radian>,
    }
}
