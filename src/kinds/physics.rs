//! `[physics]`: the engine and its rate.

use crate::spec::typed::prelude::*;

choice! {
    /// A physics engine, as specs name it.
    pub enum EngineName {
        /// rapier
        Rapier = "rapier",
        /// MuJoCo
        Mujoco = "mujoco",
        /// Our own, which steps many robots at once.
        Batch = "batch",
    }
}

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
