//! The terrain kind `flat`.

use crate::spec::typed::prelude::*;

kind! {
    pub struct Flat = "flat" {
        /// Coulomb friction coefficient between ground and feet.
        #[range(0.0, 10.0)]
        friction: f64,
    }
}
