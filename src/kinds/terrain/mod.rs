//! Terrains: the ground (built by `env/ground.rs`).

pub mod box_obstacle;
pub mod flat;
pub mod height_field;
pub mod slope;

use crate::spec::typed::prelude::*;

section! {
    /// The ground.
    pub enum Ground in "terrain", "terrain" {
        box_obstacle: BoxObstacle, flat: Flat, height_field: HeightField, slope: Slope
    }
}

impl Ground {
    /// Coulomb friction coefficient between ground and feet.
    pub fn friction(&self) -> f64 {
        match self {
            Self::BoxObstacle(ground) => ground.friction,
            Self::Flat(ground) => ground.friction,
            Self::HeightField(ground) => ground.friction,
            Self::Slope(ground) => ground.friction,
        }
    }
}
