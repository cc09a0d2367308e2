//! `[physics]`: the engine and its rate.

use crate::sim::EngineName;
use crate::spec::typed::prelude::*;

keys! {
    /// `[physics]`
    pub struct Physics in "physics" {
        /// The physics engine of training and evaluation.
        engine: EngineName,
        /// Rate of the simulation's steps; `action.rate` and `action.servo_rate` must divide it.
        #[range(1.0, 1e6)]
        rate: Quantified<Hertz>,
    }
}
