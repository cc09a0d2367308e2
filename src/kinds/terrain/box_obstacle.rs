//! The terrain kind `box_obstacle`.

use crate::spec::typed::prelude::*;

choice! {
    /// Point of a box to which a distance is measured.
    pub enum Measured {
        /// Its front.
        Front = "front",
        /// Its middle.
        Center = "center",
    }
}

kind! {
    pub struct BoxObstacle = "box_obstacle" {
        /// Coulomb friction coefficient between ground and feet.
        #[range(0.0, 10.0)]
        friction: f64,
        /// Height of the box above ground.
        #[range(0.0, 1.0)]
        height: Quantified<Metre>,
        /// Length along x.
        #[range(1e-3, 1e3)]
        #[default("\"0.4 m\"")]
        length: Quantified<Metre>,
        /// Width along y.
        #[range(1e-3, 1e3)]
        #[default("\"8 m\"")]
        width: Quantified<Metre>,
        /// Distance from the start.
        #[range(0.0, 1e3)]
        distance: Quantified<Metre>,
        /// Point of the box at `distance`.
        #[default("\"center\"")]
        reference: Measured,
    }
}
